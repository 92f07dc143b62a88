//! Planning: where the steps of a goal take a hand.
//!
//! In: a checked goal and the pose in which a hand stands. Out: the poses that its waypoints stand for ([`Waypoints`]) and
//! the path of each motion (`path_of`). The runner asks when a step begins; the check of a goal asks before anything
//! moves, so both see the same way.
//!
//! Absent on purpose: forces, time and obstacles.

mod motion;
mod waypoints;

pub(crate) use motion::{FREED_BY_M, path_of};
pub(crate) use waypoints::{OVER_TOP_M, descent_m};
pub use waypoints::{Waypoints, from_the_side, home};
