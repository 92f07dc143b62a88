//! Following a client's stream of targets: a reflex beneath a policy.
//!
//! ```text
//!  GraspTarget ─ TargetIntake ─▶ CheckedTarget ─ lead ─▶ Lead ─ module follow ─ Follower ─▶ pose, beside the other modules' wishes
//! ```
//!
//! * **In:** what a client streams, unchecked. **Out:** a pose per tick that keeps limits of speed, acceleration and jerk.
//! * **Invariants:** only the writer whose goal opened the stream is heard. A target outside the hand's own side of the table is
//!   refused before anything moves, so that two hands never come near each other (`bounds`). Silence brakes the hand; the
//!   fingers keep what they hold. How hard they hold is the other modules' matter.
//! * **Absent on purpose:** objects and obstacles beyond what fingertips feel; tilted hands.

mod axis;
mod bounds;
mod follower;
mod lead;
mod targets;

pub use axis::{Axis, Bounds};
pub use bounds::{FollowSpace, across_the_middle};
pub use follower::{Follower, Speeds};
pub use lead::Lead;
pub use targets::{CheckedTarget, TargetIntake};
