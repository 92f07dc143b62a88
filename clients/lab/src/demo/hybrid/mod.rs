//! `atas demo hybrid`: one course of mobile robots in virtual time, each component in a separate
//! process.
//!
//! ```text
//!  atas-sim course ◀── bus of robot 1 ──▶ atasd, ebts agents, coordinator
//!                  ◀── bus of robot 2 ──▶ as for robot 1, with two robots
//! ```
//!
//! This process runs the coordinators and evaluates the course. For the same seed, the result
//! equals that of `atas eval hybrid` bit for bit.

mod coordinator;
mod processes;

use atas_console::arguments::DemoHybrid;
use atas_console::{Exit, ExitError, Interrupt, Output, Progress, number, table};
use atas_evaluation::hybrid::{HybridTrial, Reflexes, RobotTrial};
use comfy_table::Cell;
use ebts::course::table_file::CourseFile;
use sim_backend::course::Scenario;

use processes::Processes;

pub(super) fn hybrid(
    arguments: &DemoHybrid,
    interrupt: &Interrupt,
    output: &mut Output,
) -> anyhow::Result<()> {
    let usage = |error: String| ExitError::with_code(Exit::Usage, error);
    let (file, _) =
        CourseFile::from_name(&arguments.table).map_err(|error| usage(error.to_string()))?;
    let object = atas_demo::object(&arguments.object)?;
    let objects = vec![object; arguments.robots.into()];
    let cast =
        Scenario::random(arguments.seed, &objects).map_err(|error| usage(error.to_string()))?;
    let reflexes = match arguments.frozen {
        true => Reflexes::Frozen,
        false => Reflexes::On,
    };
    let mut progress = Progress::new("hybrid");
    progress.show_activity("starting atas-sim course, and atasd and ebts agents for every robot");
    let processes = Processes::start(arguments, &cast, reflexes)?;
    let trial = processes.watch(interrupt, |robot, phase, now_s| {
        progress.show_activity(&format!(
            "{:>6} s  robot {}: {phase}",
            number(now_s, 1),
            robot + 1
        ));
    })?;
    drop(progress);
    if output.is_json() {
        output.json(&trial)?;
    } else {
        print(&trial, &file.hash, output)?;
    }
    match trial.failure() {
        None => Ok(()),
        Some(failure) => Err(ExitError::with_code(
            Exit::Unexpected,
            format!("the course failed: {failure}"),
        )),
    }
}

fn print(trial: &HybridTrial, hash: &str, output: &mut Output) -> anyhow::Result<()> {
    let mut lines = table(&["robot", "phase", "control owner", "began at s", "took s"]);
    for (index, robot) in (1..).zip(&trial.robots) {
        for time in &robot.phases {
            lines.add_row(vec![
                Cell::new(index),
                Cell::new(time.phase),
                Cell::new(control_owner(time.phase)),
                Cell::new(number(time.began_s, 1)),
                Cell::new(number(time.took_s, 1)),
            ]);
        }
    }
    output.table(lines)?;
    for (index, robot) in (1..).zip(&trial.robots) {
        output.line(format!("robot {index}: {}", summary(robot)))?;
    }
    output.line(format!(
        "seed {}, table {hash}, {} s simulated",
        trial.seed,
        number(trial.simulated_s, 1)
    ))
}

fn control_owner(name: &str) -> &'static str {
    use atas_evaluation::hybrid::{ControlOwner, PHASES};
    let phase = PHASES.iter().find(|phase| phase.name == name);
    match phase.map(|phase| phase.owner) {
        Some(ControlOwner::Table) => "table",
        Some(ControlOwner::Hand(_)) => "modules",
        Some(ControlOwner::Brake) | None => "none: the base brakes",
    }
}

fn summary(robot: &RobotTrial) -> String {
    let mut text = match (&robot.failure, robot.off_goal_m) {
        (Some(failure), _) => format!("{}: {failure}", robot.object),
        (None, Some(off_m)) => format!(
            "{}: placed {} mm from the goal",
            robot.object,
            number(off_m * 1e3, 1)
        ),
        (None, None) => robot.object.clone(),
    };
    if let Some(drive) = &robot.drive {
        text += &format!(
            "; carried for {} s, grip force {} N at first, {} to {} N while driving (F_2 {} N), \
             slip {} mm; base acceleration {} m/s² horizontal, {} m/s² vertical",
            number(drive.took_s, 1),
            number(drive.began_n, 2),
            number(drive.least_n, 2),
            number(drive.most_n, 2),
            number(robot.f2_n.into(), 2),
            number(drive.slip_m * 1e3, 2),
            number(drive.shake.horizontal_m_s2, 2),
            number(drive.shake.vertical_m_s2, 2),
        );
    }
    text
}
