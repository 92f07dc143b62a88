//! `atas fault`: lists the fault catalogue, and injects faults into tasks and processes.

use atas_console::arguments::{FaultAction, FaultRun};
use atas_console::{Exit, ExitError, Interrupt, Output, table};
use atas_evaluation::Task;
use atas_faults::process::Environment;
use atas_faults::{CATALOGUE, Evidence, Fault, FaultPlan, FaultReport, FaultRow, find};
use robot_model::RobotModel;
use serde_json::{Value, json};
use sim_backend::Object;

use crate::configuration::configured;
use crate::eval;

pub(crate) fn fault(
    action: &FaultAction,
    interrupt: &Interrupt,
    output: &mut Output,
) -> anyhow::Result<()> {
    match action {
        FaultAction::List => list(output),
        FaultAction::Run(arguments) => run(arguments, interrupt, output),
    }
}

fn list(output: &mut Output) -> anyhow::Result<()> {
    if output.is_json() {
        let faults: Vec<Value> = CATALOGUE.iter().map(as_json).collect();
        return output.json(&json!({ "faults": faults }));
    }
    let mut rows = table(&["fault", "what happens", "required reaction, or evidence"]);
    for fault in CATALOGUE {
        let name = format!("{} {}", fault.id, fault.name);
        rows.add_row([name, fault.about.to_owned(), reaction(fault)]);
    }
    output.table(rows)
}

fn as_json(fault: &Fault) -> Value {
    json!({
        "id": fault.id, "name": fault.name, "about": fault.about,
        "reaction": fault.evidence.reaction().map(|reaction| reaction.text()),
        "shown_by": fault.evidence.text(),
    })
}

/// Returns the required reaction, or the evidence in words.
fn reaction(fault: &Fault) -> String {
    match fault.evidence {
        Evidence::Injected(_, reaction) => reaction.text(),
        Evidence::Process(_, reaction) => format!("{}, process", reaction.text()),
        Evidence::Test(test) => {
            let (_, name) = test.rsplit_once("::").unwrap_or(("", test));
            format!("test {name}")
        }
        Evidence::Nothing(why) => format!("no evidence: {why}"),
    }
}

fn run(arguments: &FaultRun, interrupt: &Interrupt, output: &mut Output) -> anyhow::Result<()> {
    let plan = plan(arguments)?;
    let report = eval::with_progress_bar(plan.runs(), |done| plan.run(interrupt.flag(), done))?;
    if output.is_json() {
        output.json(&report)?;
    } else {
        print(&report, output)?;
    }
    if report.has_passed() {
        return Ok(());
    }
    let failed: usize = report
        .faults
        .iter()
        .map(|row| row.runs - row.passed_runs)
        .sum();
    let sentence = format!("{failed} runs failed; each failure above has its command");
    Err(ExitError::with_code(Exit::Failed, sentence))
}

fn plan(arguments: &FaultRun) -> anyhow::Result<FaultPlan> {
    let usage = |text: String| ExitError::with_code(Exit::Usage, text);
    let configured = configured(arguments.config.as_deref())?;
    let (name, robot) = configured.robot_files(arguments.robot.as_ref())?;
    let tasks = match arguments.task {
        Some(task) => vec![eval::task(task)],
        None => supported_tasks(&robot.load()?),
    };
    let object = Object::from_name_or_file(&arguments.object);
    let mut faults: Vec<&'static Fault> = Vec::new();
    for text in &arguments.faults {
        let before = faults.len();
        faults.extend(find(text));
        if faults.len() == before {
            return Err(usage(format!(
                "could not find the fault {text:?}; `atas fault list` prints all"
            )));
        }
    }
    if arguments.all {
        faults.extend(CATALOGUE);
    }
    Ok(FaultPlan {
        faults,
        tasks,
        phase: arguments.phase.clone(),
        object: object.map_err(|error| usage(error.to_string()))?,
        object_name: arguments.object.clone(),
        seeds: arguments.seeds,
        first_seed: arguments.first_seed,
        robot,
        settings: configured.settings,
        environment: Environment {
            robot: name,
            config: arguments.config.clone(),
        },
        threads: arguments.threads,
    })
}

fn supported_tasks(robot: &RobotModel) -> Vec<Task> {
    let tasks = Task::ALL.into_iter();
    tasks.filter(|task| task.is_supported_by(robot)).collect()
}

fn print(report: &FaultReport, output: &mut Output) -> anyhow::Result<()> {
    let mut rows = table(&["fault", "required reaction", "passed", "slowest", "bound"]);
    for row in report.faults.iter().filter(|row| row.runs > 0) {
        let ticks = |ticks: Option<u64>| ticks.map_or(String::new(), |ticks| ticks.to_string());
        rows.add_row([
            format!("{} {}", row.id, row.name),
            row.reaction.clone().unwrap_or_default(),
            format!("{} of {}", row.passed_runs, row.runs),
            ticks(row.worst_ticks),
            ticks(row.bound_ticks),
        ]);
    }
    if report.faults.iter().any(|row| row.runs > 0) {
        output.table(rows)?;
    }
    for row in &report.faults {
        print_row(row, output)?;
    }
    output.line(format_args!(
        "{} of {} faults of the catalogue are injected or have a test; {} unsafe runs",
        report.automated, report.catalogue, report.unsafe_outputs
    ))
}

/// Prints the failures of a fault, or its evidence if it was not run.
fn print_row(row: &FaultRow, output: &mut Output) -> anyhow::Result<()> {
    if let Some(reason) = &row.skipped {
        let (id, name) = (row.id, row.name);
        output.line(format_args!("{id} {name} is skipped: {reason}"))?;
    }
    if row.runs == 0 && row.skipped.is_some() {
        return Ok(());
    }
    if row.runs == 0 {
        let (id, name, evidence) = (row.id, row.name, &row.shown_by);
        return output.line(format_args!("{id} {name} is not injected: {evidence}"));
    }
    for failure in &row.failures {
        output.line(format_args!("failed: {failure}"))?;
    }
    Ok(())
}
