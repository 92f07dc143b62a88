//! Learning environments: a policy controls one hand and observes its tactile sensors.
//!
//! ```text
//!  action ─▶ PolicyHand ─ kinematics, gate ─▶ World ─▶ intake, perception, modules ─▶ observation
//!            (controller without tasks)         └─ ground truth ─▶ reward, end
//! ```
//!
//! * **In:** a robot, a [`Task`], objects, a seed, then one action of [`ACTIONS`] values from −1 to
//!   1 per [`STEP_TICKS`] ms.
//! * **Out:** an observation of [`observation::Layout::size`] values, a reward, an end.
//! * **Reproducible:** the same seed and actions give the same bits, alone or in a [`Batch`], on
//!   any number of threads.
//! * **Production code:** kinematics, safety gate, intake, perception. Module outputs are observed,
//!   not executed.
//! * **Reward:** from the simulator's ground truth, which is not observed.
//! * **Not included:** Python bindings (`clients/python`) and learning algorithms.
#![forbid(unsafe_code)]

mod batch;
mod environment;
mod episode;
mod error;
mod hand;
pub mod observation;
mod reward;
mod task;

pub use batch::Batch;
pub use environment::{Environment, Outcome, STEP_TICKS};
pub use error::LearningError;
pub use hand::{ACTIONS, CLOSING_M_S, MOVE_M_S};
pub use reward::End;
pub use task::Task;
