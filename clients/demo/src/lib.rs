//! Demos of the four tasks: the production processes on a separate bus, a goal, and an evaluation
//! by the simulator's ground truth.
//!
//! ```text
//!  grasp, pick_place, screw, assembly: one scenario each ─ scene, goal, evaluation
//!   │
//!   └─▶ run ─┬─ processes: atas-sim, atasd              (terminated on drop, bus removed)
//!            ├─ page ── child: atas-live                with --dashboard
//!            ├─ GoalExecution: sends the goal like any client
//!            ├─ ground truth and daemon status ─▶ punctuality
//!            └─▶ evaluation ─▶ table
//! ```
//!
//! * **In:** the command line of `atas demo` ([`atas_console::arguments`]). **Out:** a table of
//!   results, an exit code.
//! * **Invariants:** a demo communicates with the daemon only over the bus, as any client. Ctrl-C
//!   ends every process and removes every bus that a demo started.
//! * **Not included:** the demos of swarm and hybrid team; `atas-lab` runs them with [`page`]
//!   of this crate.

mod assembly;
mod grasp;
mod observed;
pub mod page;
mod pick_place;
mod processes;
mod punctuality;
mod run;
mod scenario;
mod screw;
mod table;
mod turns;

use atas_console::arguments::{Demo, DemoOptions};
use atas_console::{Exit, ExitError, Interrupt, Output, number};
use atas_core::Settings;
use atas_tasks::Task;
use atas_tasks::judge::Load;
use robot_model::{HandModel, RobotModel};
use shm_schemas::{GoalRequest, WorldTruth};
use sim_backend::{Object, Scene};

use scenario::Scenario;
use table::Row;

/// Runs the demo of a task and prints its results.
///
/// # Errors
/// A wrong argument, a process that ended, an interrupt, or an outcome other than expected.
pub fn demo(task: &Demo, interrupt: &Interrupt, output: &mut Output) -> anyhow::Result<()> {
    match task {
        Demo::Grasp(arguments) => {
            let running = &arguments.running;
            let names: Vec<&str> = if arguments.all {
                Object::names().collect()
            } else {
                vec![&arguments.object]
            };
            let objects = names
                .into_iter()
                .map(|name| grasp::Grasp::new(name, running));
            let scenarios: Vec<grasp::Grasp> = objects.collect::<anyhow::Result<_>>()?;
            show("grasp", &scenarios, running, interrupt, output)
        }
        Demo::PickPlace(arguments) => {
            let running = &arguments.running;
            let scenario = pick_place::PickPlace::new(&arguments.object, running)?;
            show("pick-place", &[scenario], running, interrupt, output)
        }
        Demo::Screw(arguments) => {
            let running = &arguments.running;
            let scenario = screw::Screw::new(&arguments.cap, running)?;
            show("screw", &[scenario], running, interrupt, output)
        }
        Demo::Assembly(arguments) => {
            let running = &arguments.running;
            let scenario = assembly::Assembly::new(&arguments.cap, running)?;
            show("assembly", &[scenario], running, interrupt, output)
        }
        Demo::Swarm(_) | Demo::Hybrid(_) => Err(ExitError::with_code(
            Exit::Usage,
            "this program runs the demos of one robot only; run `atas` instead",
        )),
    }
}

/// Runs scenarios one after another, prints the results and compares them with the expected
/// outcomes.
fn show(
    task: &str,
    scenarios: &[impl Scenario],
    running: &DemoOptions,
    interrupt: &Interrupt,
    output: &mut Output,
) -> anyhow::Result<()> {
    let mut rows = Vec::new();
    let mut ended = Ok(());
    for scenario in scenarios {
        match run::run(scenario, running, interrupt) {
            Ok(seen) => rows.push(Row::new(scenario.name(), scenario.evaluate(&seen), &seen)),
            Err(error) => {
                ended = Err(error);
                break;
            }
        }
    }
    // Results before an error are printed as well.
    table::print(task, &rows, output)?;
    ended?;
    table::verdict(&rows)
}

/// Returns a built-in object, or the object of a file.
///
/// # Errors
/// The name is unknown, or the file is invalid; the exit code is the one of wrong usage.
pub fn object(argument: &str) -> anyhow::Result<Object> {
    Object::from_name_or_file(argument)
        .map_err(|error| ExitError::with_code(Exit::Usage, error.to_string()))
}

fn cap(argument: &str) -> anyhow::Result<Object> {
    let cap = object(argument)?;
    if cap.thread.is_some() {
        return Ok(cap);
    }
    let sentence =
        format!("could not screw {argument:?}: it has no thread; name an object with a thread");
    Err(ExitError::with_code(Exit::Usage, sentence))
}

/// Simulated scene of a task, and the goal for it.
struct Setting {
    scene: Scene,
    goal: GoalRequest,
    robot: RobotModel,
}

impl Setting {
    /// Makes the default scene around an object; fails if the robot does not support the task.
    fn from_task(task: Task, running: &DemoOptions, object: Object) -> anyhow::Result<Self> {
        let usage = |error: String| ExitError::with_code(Exit::Usage, error);
        let robot = RobotModel::find(&running.robot).map_err(|error| usage(error.to_string()))?;
        task.check(&robot)
            .map_err(|error| usage(error.to_string()))?;
        let side = robot.acting_side();
        let scene = task.scene(&robot, object)?;
        let scene = match running.vary {
            true => scene.varied(running.seed),
            false => scene,
        };
        Ok(Self {
            goal: task.goal(&scene, side)?,
            scene,
            robot,
        })
    }

    fn hand(&self) -> &HandModel {
        self.robot.hand(self.robot.acting_side())
    }

    fn object(&self) -> &Object {
        &self.scene.objects[0].object
    }

    /// Returns the force required by the object and the force it tolerates in this hand.
    fn load(&self) -> Load {
        let tips = self.hand().opposed_tips();
        Load::from_object(self.object(), &Settings::default().grasp, tips)
    }
}

fn lifted(truth: &WorldTruth) -> String {
    format!("lifted {} mm", number(truth.objects[0].lifted_m * 1e3, 1))
}
