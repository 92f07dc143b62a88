//! Evaluation of an assembly: the bottle stands unturned, its cap is closed and tight.

use shm_schemas::{GoalUpdate, ObjectTruth, WorldTruth};

use super::{TURN_MAX_RAD, cap_failure, failure_unless, goal_failure, harm, in_hand_failure};

/// Largest tilt of a standing bottle, rad. Design choice (2°): above any unevenness of the table,
/// far below tipping.
const STANDING_TILT_MAX_RAD: f64 = 2.0 * core::f64::consts::PI / 180.0;

/// Result of an assembly.
#[derive(Clone, Debug, PartialEq)]
pub struct Assembly {
    /// Failure key.
    pub failure: Option<String>,
    /// Holding torque of the cap over its thread's friction; 0 off the thread.
    pub tightness: f64,
    /// Tilt of the bottle at the end, rad.
    pub tilt_rad: f64,
    /// Rotation of the bottle about its axis since the start, rad.
    /// [`ObjectTruth::turn_in_hand_rad`] does not measure it while the bottle stands.
    pub turned_rad: f64,
}

impl Assembly {
    /// Evaluates cap (first object) and bottle (second object); `start` is the ground truth before
    /// the goal.
    #[must_use]
    pub fn evaluate(end: &GoalUpdate, start: &WorldTruth, truth: &WorldTruth) -> Self {
        let [cap, bottle, ..] = &truth.objects;
        let turned_rad = turn_rad(&start.objects[1].orientation, &bottle.orientation);
        let engaged = cap.cap_engaged != 0;
        let failure = with_part("bottle", harm(bottle))
            .or_else(|| with_part("cap", harm(cap)))
            .or_else(|| goal_failure(end))
            .or_else(|| failure_unless(stands(bottle), "bottle not standing"))
            .or_else(|| with_part("cap", cap_failure(cap)))
            .or_else(|| failure_unless(cap.cap_closed != 0, "cap not closed"))
            .or_else(|| with_part("cap", in_hand_failure(cap)))
            .or_else(|| with_part("bottle", in_hand_failure(bottle)))
            .or_else(|| {
                failure_unless(
                    turned_rad.abs() <= TURN_MAX_RAD,
                    "bottle turned in the hand",
                )
            });
        let tightness = cap.cap_holding_n_m / cap.cap_friction_n_m;
        Self {
            failure,
            tightness: if engaged { tightness } else { 0.0 },
            tilt_rad: bottle.tilt_rad,
            turned_rad,
        }
    }
}

/// Returns the rotation about the upright axis between two orientations of an upright object, rad,
/// −π to π.
fn turn_rad(before: &[f64; 4], after: &[f64; 4]) -> f64 {
    let yaw_rad =
        |[w, x, y, z]: [f64; 4]| libm::atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z));
    let turn_rad = yaw_rad(*after) - yaw_rad(*before);
    libm::atan2(libm::sin(turn_rad), libm::cos(turn_rad))
}

fn with_part(part: &str, harm: Option<String>) -> Option<String> {
    harm.map(|harm| format!("{part} {harm}"))
}

fn stands(bottle: &ObjectTruth) -> bool {
    bottle.tilt_rad.abs() <= STANDING_TILT_MAX_RAD && bottle.table_n > 0.0
}
