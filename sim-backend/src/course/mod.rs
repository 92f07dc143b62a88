//! A course: a square field, wheeled bases that carry robots, for each an object of light to fetch and a goal of light.
//!
//! ```text
//!  Layout ─▶ Course ──sense──▶ row of a behaviour table (three IR, two photo sensors, as on the swarm's field)
//!              ▲  └──ride───▶ how the base moves: World::ride of the robot on it
//!              └──guard── wheel levels ◀─ table, every 100 ms, and a pace
//! ```
//!
//! * **In:** a [`Layout`], wheel levels (0 stop, 1 medium, 2 high: paper Table 1) once per frame. **Out:** rows, rides, and what
//!   went wrong ([`Mishap`](shm_schemas::Mishap)). A [`Host`] runs a [`Cast`] so that coordinators and tables may be anywhere.
//! * **Right of way:** robots have it in turn, 30 s each; a robot knows how far the one that has it is ([`Course::to_first_m`]), and
//!   whoever decides may let it stand meanwhile.
//! * **Invariants:** deterministic, no clock, randomness only from the seed; a base keeps its limits of acceleration and jerk, and
//!   clear of walls, objects and other bases, whatever it is told. That it does is judged apart: one that had a mishap all the
//!   same brakes and stays.
//! * **Absent on purpose:** the robot on the base with its hands (that is [`World`](crate::World)), whoever decides, slip of the wheels. A base
//!   is a disc, and a robot with its arms before it a larger one; the arms' own shape does not count.
//!
//! Lengths are in metres, angles in radians from +x towards +y, the field's centre is the origin. Numbers are ours: a small
//! service robot.

mod base;
mod cast;
mod drive;
mod floor;
mod guard;
mod host;
mod layout;
mod rovers;
mod sight;

pub use ::field::{Responses, Wheels};
pub use base::{Base, HIGH_M_S, Pace, Place, STEP_S};
pub use cast::{Cast, Player, SIDE};
pub use drive::{DriveFigures, Shake};
pub use floor::Floor;
pub use host::{Ended, FRAME_TICKS, Host, SETTLE_TICKS};
pub use layout::{CourseError, HALF_SIDE_M, LANES_MAX, Lane, Layout};
pub use rovers::{Course, Light};
pub use sight::EYES_M;

/// Length of a frame, in which a table is read once, s.
pub const FRAME_S: f64 = 0.1;
/// Steps of a base in a frame.
pub const FRAME_STEPS: u64 = 20;
/// Ticks of the hands' world in a step of the base.
const STEP_TICKS: u64 = 5;
