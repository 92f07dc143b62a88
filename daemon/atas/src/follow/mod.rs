//! Teleoperation: a hand tracks a client's stream of targets.
//!
//! ```text
//!  GraspTarget ─ TargetIntake ─▶ ValidatedTarget ─▶ TeleopTarget ─ module ─ MotionLimiter ─▶ pose
//! ```
//!
//! * **Input:** unchecked targets. **Output:** a pose per tick within limits of speed, acceleration
//!   and jerk.
//! * **Invariants:** only the writer whose goal opened the stream is accepted. Targets outside the
//!   hand's side of the table are rejected, so that two hands never meet (`bounds`). Silence brakes
//!   the hand; the fingers keep their grip. Other modules control the grip force.
//! * **Out of scope:** obstacles without tactile contact; tilted hands.

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
