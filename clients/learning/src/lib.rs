//! Learning environments: a policy moves one hand and its two fingers and feels what they touch.
//!
//! ```text
//!  action ─▶ PolicyHand ─ arbiter's slew, kinematics, safety gate ─▶ World ─ sense ─▶ intake, perception, modules ─▶ observation
//!            (the controller's own parts, without its tasks)           └─ truth ─▶ reward, end
//! ```
//!
//! * **In:** a [`Task`], objects, a seed, then one action of [`ACTIONS`] numbers from −1 to 1 per [`STEP_TICKS`] ms. **Out:** an
//!   observation of [`observation::SIZE`] numbers, a reward, an end.
//! * **Invariants**
//!   * The same seed and the same actions give the same bits, alone or in a [`Batch`], on any number of threads.
//!   * What the policy asks for reaches the joints through the production kinematics and the production safety gate; what it
//!     is told of forces comes through the production intake and perception. What the modules say is only told, not done.
//!   * Rewards come from the simulator's truth, which no observation holds.
//!   * An action that is not finite is refused; nothing moves then.
//! * **Absent on purpose:** Python, spaces and wrappers (`clients/python`), and any learning.
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
