//! Planning: grasp poses of a goal's waypoints ([`Waypoints`]) and paths of its motions
//! (`path_of`).
//!
//! Inputs: a validated goal and the current grasp pose. Shared by task executor and goal check. Not
//! covered: forces, time, obstacles.

mod motion;
mod waypoints;

pub(crate) use motion::{RELEASED_BY_M, path_of};
pub(crate) use waypoints::{TOP_CLEARANCE_M, approach_height_m};
pub use waypoints::{Waypoints, home_pose, side_grasp};
