//! `atas demo hybrid`: one course, phase by phase, in process and in virtual time: the same bits as the trials of `atas eval
//! hybrid`.

use anyhow::Context;
use atas_console::arguments::DemoHybrid;
use atas_console::{Ended, Exit, Output, Progress, number, table};
use atas_evaluation::hybrid::{HybridPlan, HybridTrial, Reflexes, RobotTrial};
use comfy_table::Cell;
use ebts::course::table_file::CourseFile;
use robot_model::RobotModel;

/// `atas demo hybrid`.
pub(super) fn hybrid(arguments: &DemoHybrid, output: &mut Output) -> anyhow::Result<()> {
    let (file, table) = CourseFile::named(&arguments.table)
        .map_err(|error| Ended::with(Exit::Usage, error.to_string()))?;
    let plan = HybridPlan {
        robots: arguments.robots.into(),
        trials: 1,
        first_seed: arguments.seed,
        table,
        reflexes: match arguments.frozen {
            true => Reflexes::Frozen,
            false => Reflexes::On,
        },
        objects: vec![super::object(&arguments.object)?],
        threads: 1,
        settings: atas_core::Settings::default(),
    };
    let model = RobotModel::two_hand_arm().context("could not load the built-in robot model")?;
    let mut progress = Progress::new("hybrid");
    let trial = plan.trial(&model, 0, |robot, phase, now_s| {
        progress.note(&format!(
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
        Some(failure) => Err(Ended::with(
            Exit::Unexpected,
            format!("the course was not done: {failure}"),
        )),
    }
}

fn print(trial: &HybridTrial, hash: &str, output: &mut Output) -> anyhow::Result<()> {
    let mut lines = table(&["robot", "phase", "who has the say", "began at s", "took s"]);
    for (index, robot) in (1..).zip(&trial.robots) {
        for time in &robot.phases {
            lines.add_row(vec![
                Cell::new(index),
                Cell::new(time.phase),
                Cell::new(say(time.phase)),
                Cell::new(number(time.began_s, 1)),
                Cell::new(number(time.took_s, 1)),
            ]);
        }
    }
    output.table(lines)?;
    for (index, robot) in (1..).zip(&trial.robots) {
        output.line(format!("robot {index}: {}", account(robot)))?;
    }
    output.line(format!(
        "seed {}, table {hash}, {} s simulated",
        trial.seed,
        number(trial.simulated_s, 1)
    ))
}

/// Who has the say in a phase.
fn say(name: &str) -> &'static str {
    use atas_evaluation::hybrid::{PHASES, Say};
    let phase = PHASES.iter().find(|phase| phase.name == name);
    match phase.map(|phase| phase.say) {
        Some(Say::Table) => "table",
        Some(Say::Hand(_)) => "modules",
        Some(Say::Nobody) | None => "nobody: the base brakes",
    }
}

fn account(robot: &RobotTrial) -> String {
    let mut text = match (&robot.failure, robot.off_goal_m) {
        (Some(failure), _) => format!("{}: {failure}", robot.object),
        (None, Some(off_m)) => format!(
            "{}: set down {} mm from the goal",
            robot.object,
            number(off_m * 1e3, 1)
        ),
        (None, None) => robot.object.clone(),
    };
    if let Some(drive) = &robot.drive {
        text += &format!(
            "; carried for {} s, pressing {} N at first, {} to {} N on the way (F_2 {} N), slip {} mm; shaken by {} m/s² along the \
             floor, {} m/s² upwards",
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
