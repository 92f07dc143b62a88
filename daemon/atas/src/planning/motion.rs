//! Conversion of a step's motion into a path.

use super::waypoints::Waypoints;
use crate::path::{Path, Speeds};
use crate::settings::Settings;
use crate::tasks::Motion;
use robot_model::GraspPose;

/// Opening travel of each grasp side on release, m (design choice: clears a bulging soft object).
const OPEN_BY_M: f64 = 0.012;
/// Opening travel, m, and duration, s, of the fast release (design choice: 50 rad/s² of the gate's
/// 60). A faster release swings back and grips the object again.
const RELEASE_BY_M: f64 = 0.003;
const RELEASE_S: f64 = 0.085;
/// Distance of each grasp side from the released object, m, if the hand opens that far.
pub(crate) const RELEASED_BY_M: f64 = RELEASE_BY_M + OPEN_BY_M;

/// Returns the path of a motion that starts at `now`, where `before` is the previous path.
pub(crate) fn path_of(
    motion: Motion,
    now: &GraspPose,
    waypoints: &Waypoints,
    before: &Path,
    settings: &Settings,
) -> Path {
    let speeds = &settings.motion;
    let free = Speeds {
        move_m_s: speeds.reach_m_s,
        turn_rad_s: speeds.turn_rad_s,
        open_m_s: waypoints.finger_speed_m_s(speeds.open_m_s),
        wrist_turn_radius_m: waypoints.wrist_turn_radius_m(),
    };
    let gripping = |waypoint, move_m_s| {
        let speeds = Speeds { move_m_s, ..free };
        Path::gripping(*now, waypoints.pose(waypoint, now), &speeds)
    };
    match motion {
        Motion::Stay | Motion::Lower | Motion::Square | Motion::Teleop | Motion::Brake => {
            Path::stationary(*now)
        }
        Motion::Reach(waypoint) => Path::over_obstacles(*now, waypoints.pose(waypoint, now), &free),
        Motion::Withdraw => Path::over_obstacles(*now, before.pose_at(0.0), &free),
        Motion::Carry(waypoint) => gripping(waypoint, speeds.lift_m_s),
        Motion::Convey(waypoint) => gripping(waypoint, settings.place.convey_m_s),
        Motion::Open => Path::free(*now, waypoints.opened(now, OPEN_BY_M), &free),
        Motion::LetGo => {
            let speeds = Speeds {
                open_m_s: waypoints.finger_speed_m_s(RELEASE_BY_M / RELEASE_S),
                ..free
            };
            Path::free(*now, waypoints.opened(now, RELEASE_BY_M), &speeds)
        }
    }
}
