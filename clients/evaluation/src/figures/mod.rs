//! SVG figures of a task: forces at the fingertips, module activity, and ground truth.
//!
//! **In:** a task, an object, a seed ([`draw`]); or goals ([`Goals`]) of recorded runs, each as a
//! [`GoalTrace`]. **Out:** one SVG file, always the same bytes. `figure` and `phases` hold shared
//! code. Forces, thresholds and modules come from the controller's reports. Heights, torques and
//! support force of an offline run are ground truth, absent from recordings.
//!
//! | figure | shows |
//! |---|---|
//! | `grasping` | F_n and F_t between F_1 and F_2, the lift, and a lane per module |
//! | `placing` | the release: support force, grip, opening and height around the contact |
//! | `screwing` | Fig. 6 (commanded square, path per cycle), cap angle and torque |
//! | `assembling` | steps and grips of both hands, angle and torque of the cap |
//! | `recorded_goals` | forces, height, slip, modules of recorded goals; overlays; key events |
//! | `residuals` | errors of a calibration over the known force |

mod assembling;
mod figure;
mod goal_trace;
mod goals;
mod grasping;
mod phases;
mod placing;
mod recorded_goals;
mod residuals;
mod screwing;
mod trace;

use sim_backend::{Object, Scene};

use crate::Task;
use trace::Trace;

pub use goal_trace::GoalTrace;
pub use goals::{Goal, GoalSelection, Goals};
pub use recorded_goals::{explained, overlay};
pub use residuals::residuals;

/// Runs a task offline with an object and draws it.
///
/// # Errors
/// The world cannot be created, or the task did not reach the part that the figure shows.
pub fn draw(task: Task, object: &Object, seed: u64) -> anyhow::Result<String> {
    let trace = Trace::run(task, object, seed)?;
    match task {
        Task::Grasp => grasping::draw(&trace),
        Task::PickPlace => placing::draw(&trace),
        Task::Screw => screwing::draw(&trace),
        Task::Assembly => assembling::draw(&trace),
    }
}

/// Returns the default object of a task's figure.
///
/// # Errors
/// The built-in object's file is invalid.
pub fn default_object(task: Task) -> Result<Object, sim_backend::ObjectError> {
    Object::built_in(match task {
        Task::Grasp | Task::PickPlace => Scene::OBJECT,
        Task::Screw | Task::Assembly => Scene::CAP,
    })
}
