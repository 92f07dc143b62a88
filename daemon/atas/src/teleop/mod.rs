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
mod limiter;
mod target;
mod targets;

pub use axis::{Axis, Bounds};
pub use bounds::{TeleopWorkspace, arm_across_middle};
pub use limiter::{MotionLimiter, SpeedLimits};
pub use target::TeleopTarget;
pub use targets::{TargetIntake, ValidatedTarget};
