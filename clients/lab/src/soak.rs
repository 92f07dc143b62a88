//! `atas soak`: random tasks with random events in virtual time, judged at every tick.

use atas_console::arguments::Soak;
use atas_console::{Exit, ExitError, Interrupt, Output};
use atas_faults::soak::{SoakPlan, SoakReport};
use robot_model::RobotFiles;

use crate::configuration::configured;
use crate::eval;

/// Robots of a soak without --robot: all joints of two arms, and the robot with most joints per
/// arm.
const ROBOTS: [&str; 2] = ["two-hand-arm", "arm7-gripper"];

pub(crate) fn soak(
    arguments: &Soak,
    interrupt: &Interrupt,
    output: &mut Output,
) -> anyhow::Result<()> {
    let configured = configured(arguments.config.as_deref())?;
    let names: Vec<&str> = match (&arguments.robot, &arguments.config) {
        (Some(robot), _) => vec![robot],
        (None, Some(_)) => vec![&configured.robot],
        (None, None) => ROBOTS.to_vec(),
    };
    let robots: Result<Vec<RobotFiles>, _> = names.into_iter().map(RobotFiles::find).collect();
    let usage =
        |error: &dyn std::fmt::Display| ExitError::with_code(Exit::Usage, error.to_string());
    let plan = SoakPlan {
        ticks: arguments.ticks,
        seed: arguments.seed,
        episode: arguments.episode,
        events: arguments.events.clone(),
        robots: robots.map_err(|error| usage(&error))?,
        options: options(arguments),
        settings: configured.settings,
        threads: arguments.threads,
    };
    let report = eval::with_progress_bar(plan.episodes(), |done| plan.run(interrupt.flag(), done))?;
    if output.is_json() {
        output.json(&report)?;
    } else {
        print(&report, output)?;
    }
    if report.failures.is_empty() {
        return Ok(());
    }
    let failed = report.failures.len();
    let sentence = format!("{failed} episodes failed; each failure above has its command");
    Err(ExitError::with_code(Exit::Failed, sentence))
}

/// Returns the options that a repeating command needs, with a space before each.
fn options(arguments: &Soak) -> String {
    let robot = arguments.robot.iter();
    let robot = robot.map(|robot| format!(" --robot {robot}"));
    let config = arguments.config.iter();
    let config = config.map(|file| format!(" --config {}", file.display()));
    robot.chain(config).collect()
}

fn print(report: &SoakReport, output: &mut Output) -> anyhow::Result<()> {
    for failure in &report.failures {
        output.line(format_args!(
            "failed: {}: {}",
            failure.command, failure.violation
        ))?;
    }
    output.line(format_args!(
        "{} ticks in {} episodes, seed {}: {} violations, {:.0} ticks/s",
        report.ticks, report.episodes, report.seed, report.violations, report.ticks_per_s
    ))
}
