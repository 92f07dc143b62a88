//! Figures of a task as SVG: what the fingertips felt, which module worked when, and what truly became of it.
//!
//! **In:** a task, an object, a seed. **Out:** one file, the same bytes every time. The trace of a rehearsal is
//! drawn by one file per figure; `figure` holds what they share. Forces, thresholds and modules are the controller's own
//! reports; heights, torques and the support's force are the simulator's truth, which no controller sees.
//!
//! | figure | shows |
//! |---|---|
//! | `grasping` | F_n and F_t between F_1 and F_2, the lift, and a lane per module |
//! | `placing` | the release: the support's force, the grip, opening and height around the contact |
//! | `screwing` | Fig. 6 (the square and what contact made of it, cycle by cycle), the cap's angle and torque |
//! | `assembling` | what both hands do, their grips, the cap's angle and torque |

mod assembling;
mod figure;
mod grasping;
mod placing;
mod screwing;
mod trace;

use std::path::Path;

use anyhow::Context;
use sim_backend::Object;

use crate::arguments::Plot;
use crate::eval::Task;
use crate::exit::{Ended, Exit};
use crate::output::Output;
use trace::Trace;

/// `atas plot`.
pub(crate) fn plot(plot: &Plot, output: &mut Output) -> anyhow::Result<()> {
    let (task, arguments) = match plot {
        Plot::Grasp(arguments) => (Task::Grasp, arguments),
        Plot::PickPlace(arguments) => (Task::PickPlace, arguments),
        Plot::Screw(arguments) => (Task::Screw, arguments),
        Plot::Assembly(arguments) => (Task::Assembly, arguments),
    };
    let usage = |error: sim_backend::ObjectError| Ended::with(Exit::Usage, error.to_string());
    let object = match &arguments.object {
        Some(name) => Object::named_or_file(name).map_err(usage)?,
        None => usual(task).map_err(usage)?,
    };
    let svg = draw(task, &object, arguments.seed)?;
    write(&arguments.out, &svg)?;
    output.line(format!("wrote {}", arguments.out.display()))
}

/// Rehearses a task with an object and draws it.
///
/// # Errors
/// The world cannot be made, or the task never came to what the figure shows.
pub fn draw(task: Task, object: &Object, seed: u64) -> anyhow::Result<String> {
    let trace = Trace::of(task, object, seed)?;
    match task {
        Task::Grasp => grasping::draw(&trace),
        Task::PickPlace => placing::draw(&trace),
        Task::Screw => screwing::draw(&trace),
        Task::Assembly => assembling::draw(&trace),
    }
}

fn usual(task: Task) -> Result<Object, sim_backend::ObjectError> {
    Object::built_in(match task {
        Task::Grasp | Task::PickPlace => "wood",
        Task::Screw | Task::Assembly => "cap",
    })
}

fn write(path: &Path, svg: &str) -> anyhow::Result<()> {
    std::fs::write(path, svg).with_context(|| {
        let path = path.display();
        format!("could not write {path}; name a file in a folder that exists and may be written")
    })
}
