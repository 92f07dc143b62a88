//! Planning: grasp poses of a goal's waypoints ([`Waypoints`]) and paths of its motions
//! (`path_of`).
//!
//! Inputs: a validated goal and the current grasp pose. Shared by task executor and goal check. Not
//! covered: forces, time, obstacles.

mod motion;
mod waypoints;

pub(crate) use motion::{FREED_BY_M, path_of};
pub(crate) use waypoints::{OVER_TOP_M, descent_m};
pub use waypoints::{Waypoints, from_the_side, home};
