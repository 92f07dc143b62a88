//! Assembly: whether the bottle stands as it was held, and its cap is closed and tight.

use shm_schemas::{GoalUpdate, ObjectTruth, WorldTruth};

use super::{TURN_MAX_RAD, ended, harmed, loose, moved_in_hand, unless};

/// Most that a standing bottle may tilt, rad (ours: 2°, beyond any unevenness of the table and far from tipping).
const STANDING_RAD: f64 = 2.0 * core::f64::consts::PI / 180.0;

/// What became of an assembly.
#[derive(Clone, Debug, PartialEq)]
pub struct Assembly {
    /// Why it is no success; `None` if it is.
    pub failure: Option<String>,
    /// Torque that it takes to turn the cap any further over the friction of its thread; 0 for a cap beside it.
    pub tightness: f64,
    /// How far the bottle tilts at the end, rad.
    pub tilt_rad: f64,
    /// How far the bottle has turned about its upright axis from how it stood at the start, rad: it stands while it is held,
    /// so that the hand's own measure of a turn ([`ObjectTruth::turn_in_hand_rad`]) does not begin.
    pub turned_rad: f64,
}

impl Assembly {
    /// Of the first object, a cap, and the second, its bottle; `start` is the truth before the goal.
    #[must_use]
    pub fn of(end: &GoalUpdate, start: &WorldTruth, truth: &WorldTruth) -> Self {
        let [cap, bottle, ..] = &truth.objects;
        let turned_rad = turn_rad(&start.objects[1].orientation, &bottle.orientation);
        let engaged = cap.cap_engaged != 0;
        let failure = of("bottle", harmed(bottle))
            .or_else(|| of("cap", harmed(cap)))
            .or_else(|| ended(end))
            .or_else(|| unless(stands(bottle), "bottle not standing"))
            .or_else(|| of("cap", loose(cap)))
            .or_else(|| unless(cap.cap_closed != 0, "cap not closed"))
            .or_else(|| of("cap", moved_in_hand(cap)))
            .or_else(|| of("bottle", moved_in_hand(bottle)))
            .or_else(|| {
                unless(
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

/// Turn about the upright axis from one orientation to another of an upright object, rad, −π to π.
fn turn_rad(before: &[f64; 4], after: &[f64; 4]) -> f64 {
    let yaw_rad =
        |[w, x, y, z]: [f64; 4]| libm::atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z));
    let turn_rad = yaw_rad(*after) - yaw_rad(*before);
    libm::atan2(libm::sin(turn_rad), libm::cos(turn_rad))
}

fn of(part: &str, harm: Option<String>) -> Option<String> {
    harm.map(|harm| format!("{part} {harm}"))
}

fn stands(bottle: &ObjectTruth) -> bool {
    bottle.tilt_rad.abs() <= STANDING_RAD && bottle.table_n > 0.0
}
