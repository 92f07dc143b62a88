//! From a step's motion to a path.

use super::waypoints::Waypoints;
use crate::path::{Path, Speeds};
use crate::settings::Settings;
use crate::tasks::Motion;
use robot_model::GraspFrame;

/// How far each finger opens when letting go, if the hand opens so far, m (ours: clear of a bulging soft object).
const OPEN_BY_M: f64 = 0.012;
/// The same at the moment an object stands, m, and how long it takes, s (ours: as fast as the gate lets the joints
/// accelerate, 50 rad/s² of its 60; what asks for more swings back and grips the object again).
const LET_GO_BY_M: f64 = 0.003;
const LET_GO_S: f64 = 0.085;
/// How far each finger is then from what it held, if the hand opens so far, m.
pub(crate) const FREED_BY_M: f64 = LET_GO_BY_M + OPEN_BY_M;

/// The path of a motion for a hand that is at `now` and whose path was `before`.
pub(crate) fn path_of(
    motion: Motion,
    now: &GraspFrame,
    waypoints: &Waypoints,
    before: &Path,
    settings: &Settings,
) -> Path {
    let speeds = &settings.motion;
    let free = Speeds {
        move_m_s: speeds.reach_m_s,
        turn_rad_s: speeds.turn_rad_s,
        open_m_s: waypoints.finger_speed_m_s(speeds.open_m_s),
    };
    let gripping = |waypoint, move_m_s| {
        let speeds = Speeds { move_m_s, ..free };
        Path::gripping(*now, waypoints.pose(waypoint, now), &speeds)
    };
    match motion {
        Motion::Stay | Motion::Lower | Motion::Square | Motion::Follow | Motion::Brake => {
            Path::stay(*now)
        }
        Motion::Reach(waypoint) => Path::over(*now, waypoints.pose(waypoint, now), &free),
        Motion::Withdraw => Path::over(*now, before.at(0.0), &free),
        Motion::Carry(waypoint) => gripping(waypoint, speeds.lift_m_s),
        Motion::Convey(waypoint) => gripping(waypoint, settings.place.convey_m_s),
        Motion::Open => Path::free(*now, waypoints.opened(now, OPEN_BY_M), &free),
        Motion::LetGo => {
            let speeds = Speeds {
                open_m_s: waypoints.finger_speed_m_s(LET_GO_BY_M / LET_GO_S),
                ..free
            };
            Path::free(*now, waypoints.opened(now, LET_GO_BY_M), &speeds)
        }
    }
}
