//! `atas eval robots` and `atas eval skins`: same trials with other built-in robots and other
//! fingertips.

use atas_console::arguments::Variants;
use atas_console::{Interrupt, Output};
use atas_evaluation::{Condition, Evaluated, NamedErrors, Noise, Plan, Report, Task, seeds};
use atas_evaluation::{RobotResults, SkinResults, robots_table, skins_table};
use robot_model::{RobotFiles, SHIPPED, TWO_HAND_ARM};
use shm_schemas::layout::NamedLayout;

use super::summary::{make_folder, print, save};

const TASKS: [Task; 3] = [Task::Grasp, Task::PickPlace, Task::Screw];
/// Fingertips of the two-hand arm with a remark: the paper's first, then those that cannot sense
/// incipient slip.
const SKINS: [(&str, &str); 4] = [
    ("dome-41", ", the paper's"),
    ("dome-1", ", one element"),
    ("flat-4x4-4.5", ""),
    ("cylinder-4x4-4.5-12", ""),
];

/// Evaluates every built-in robot except the two-hand arm, in the tasks that its hand supports.
pub(super) fn robots(
    arguments: &Variants,
    interrupt: &Interrupt,
    output: &mut Output,
) -> anyhow::Result<()> {
    make_folder(arguments.golden.as_deref())?;
    let (mut tried, mut evaluated) = (Vec::new(), Vec::new());
    for robot in SHIPPED
        .into_iter()
        .filter(|robot| robot.name != TWO_HAND_ARM.name)
    {
        let model = robot.load()?;
        let mut reports = Vec::new();
        for task in TASKS {
            let report = match task.is_supported_by(&model) {
                true => Some(run(
                    &robot,
                    None,
                    task,
                    arguments,
                    interrupt,
                    &mut evaluated,
                )?),
                false => None,
            };
            reports.push((task, report));
        }
        let hand = model.hand(model.acting_side());
        tried.push(RobotResults {
            robot: robot.name.to_string(),
            turns_by_wrist: hand.capabilities().cap_turning_by_wrist,
            reports,
        });
    }
    finish(
        "robots",
        &robots_table(&tried),
        arguments,
        &evaluated,
        output,
    )
}

pub(super) fn skins(
    arguments: &Variants,
    interrupt: &Interrupt,
    output: &mut Output,
) -> anyhow::Result<()> {
    make_folder(arguments.golden.as_deref())?;
    let (mut tried, mut evaluated) = (Vec::new(), Vec::new());
    for (name, about) in SKINS {
        let skin = Some(name.parse()?);
        let report = run(
            &TWO_HAND_ARM,
            skin,
            Task::Grasp,
            arguments,
            interrupt,
            &mut evaluated,
        )?;
        tried.push(SkinResults {
            name: format!("`{name}`{about}"),
            report,
        });
    }
    finish("skins", &skins_table(&tried), arguments, &evaluated, output)
}

/// Evaluates one task at full sensor rate and default noise. Appends the trials to `evaluated`;
/// returns the report.
fn run(
    robot: &RobotFiles,
    skin: Option<NamedLayout>,
    task: Task,
    arguments: &Variants,
    interrupt: &Interrupt,
    evaluated: &mut Vec<Evaluated>,
) -> anyhow::Result<Report> {
    let plan = Plan {
        robot: robot.clone(),
        skin,
        task,
        objects: task.objects()?,
        trials: arguments.trials,
        first_seed: arguments.first_seed.unwrap_or(seeds::EVALUATION_START),
        conditions: vec![Condition {
            noise: Noise::Scale(1.0),
            rate_hz: 1000,
            errors: NamedErrors::none(),
            sensor_model: None,
        }],
        baselines: Vec::new(),
        compare_everywhere: false,
        engine: None,
        threads: arguments.threads,
        settings: atas_core::Settings::default(),
    };
    let run = super::run(&plan, interrupt)?;
    let report = run.report.clone();
    evaluated.push(run);
    Ok(report)
}

fn finish(
    name: &str,
    text: &str,
    arguments: &Variants,
    evaluated: &[Evaluated],
    output: &mut Output,
) -> anyhow::Result<()> {
    print(arguments.markdown, evaluated, text, output)?;
    match &arguments.golden {
        Some(folder) => save(folder, name, text, evaluated),
        None => Ok(()),
    }
}
