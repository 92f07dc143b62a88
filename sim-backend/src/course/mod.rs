//! Course: a square field with wheeled bases that carry robots. Each robot fetches a luminous
//! object and carries it to a luminous goal.
//!
//! ```text
//!  Layout ─▶ Course ──sense─▶ row of a behaviour table (three IR, two photo sensors)
//!              ▲  └─motion─▶ motion of the base, input of the robot's World
//!              └─ collision guard ◀─ wheel levels and pace ◀─ table, every 100 ms
//! ```
//!
//! * **Inputs:** a [`Layout`]; wheel levels (0 stop, 1 medium, 2 high: paper Table 1) per frame.
//! * **Outputs:** table rows, base motions, mishaps ([`Mishap`](shm_schemas::Mishap)). A [`Host`]
//!   runs a [`Scenario`] with coordinators and tables in any process.
//! * **Right of way:** 30 s for each robot in turn. The other robots know their distance to it
//!   ([`Course::distance_to_priority_m`]) and may stop.
//! * **Invariants:** deterministic, without a clock; randomness only from the seed. Under any
//!   command a base keeps its limits of acceleration and jerk and stays clear of walls, objects and
//!   other bases. An independent check reports violations as mishaps; the base then brakes and
//!   stays.
//! * **Excluded:** hands and arms (see [`World`](crate::World)), coordinators, wheel slip. A base
//!   is a disc; a robot with its arms in front is a larger disc.
//!
//! Units: metres, radians from +x towards +y; the origin is the field's centre. Dimensions model a
//! small service robot (design choice).

mod base;
mod collision_guard;
mod drive;
mod floor;
mod host;
mod layout;
mod rovers;
mod scenario;
mod sensing;

pub use ::field::{Responses, Wheels};
pub use base::{Base, HIGH_M_S, Pace, PlanarPose, STEP_S};
pub use drive::{BaseAcceleration, DriveFigures};
pub use floor::Floor;
pub use host::{FRAME_TICKS, Host, RobotResult, SETTLE_TICKS};
pub use layout::{CourseError, HALF_SIDE_M, LANES_MAX, Lane, Layout};
pub use rovers::{Course, Light};
pub use scenario::{RobotSetup, SIDE, Scenario};
pub use sensing::PHOTO_SENSORS_M;

/// Length of a frame, s; the table is read once per frame.
pub const FRAME_S: f64 = 0.1;
/// Steps of a base per frame.
pub const FRAME_STEPS: u64 = 20;
/// Ticks of the hands' world per step of the base.
const STEP_TICKS: u64 = 5;
