//! Figures of a task as SVG: what the fingertips felt, which module worked when, and what truly became of it.
//!
//! **In:** a task, an object, a seed ([`draw`]); or the recordings of real runs, of each a goal
//! ([`Goals`]) as its [`Course`]. **Out:** one file, the
//! same bytes every time. The trace of an offline run is drawn by one file per figure; `figure` and `phases` hold what they
//! share. Forces, thresholds and modules are the controller's own reports; heights, torques and the support's force of an
//! offline run are the simulator's truth, which no controller sees, and which no recording has.
//!
//! | figure | shows |
//! |---|---|
//! | `grasping` | F_n and F_t between F_1 and F_2, the lift, and a lane per module |
//! | `placing` | the release: the support's force, the grip, opening and height around the contact |
//! | `screwing` | Fig. 6 (the square and what contact made of it, cycle by cycle), the cap's angle and torque |
//! | `assembling` | what both hands do, their grips, the cap's angle and torque |
//! | `pursuing` | of real runs: forces between thresholds, height, slip, modules; several over each other; what decided |
//! | `residuals` | errors of a calibration over the known force |

mod assembling;
mod course;
mod figure;
mod goals;
mod grasping;
mod phases;
mod placing;
mod pursuing;
mod residuals;
mod screwing;
mod trace;

use sim_backend::{Object, Scene};

use crate::task::Task;
use trace::Trace;

pub use course::Course;
pub use goals::{Choice, Goal, Goals};
pub use pursuing::{explained, overlay};
pub use residuals::residuals;

/// Runs a task offline with an object and draws it.
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

/// The object of a task's figure where none is named.
///
/// # Errors
/// The built-in object's file is wrong.
pub fn usual(task: Task) -> Result<Object, sim_backend::ObjectError> {
    Object::built_in(match task {
        Task::Grasp | Task::PickPlace => Scene::OBJECT,
        Task::Screw | Task::Assembly => Scene::CAP,
    })
}
