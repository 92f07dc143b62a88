//! Assembly: whether the bottle stands and its cap is closed.

use shm_schemas::{GoalUpdate, ObjectTruth, WorldTruth};

use super::{ended, harmed, unless};

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
}

impl Assembly {
    /// Of the first object, a cap, and the second, its bottle.
    #[must_use]
    pub fn of(end: &GoalUpdate, truth: &WorldTruth) -> Self {
        let [cap, bottle, ..] = &truth.objects;
        let engaged = cap.cap_engaged != 0;
        let failure = of("bottle", harmed(bottle))
            .or_else(|| of("cap", harmed(cap)))
            .or_else(|| ended(end))
            .or_else(|| unless(stands(bottle), "bottle not standing"))
            .or_else(|| unless(engaged, "cap off its thread"))
            .or_else(|| unless(cap.cap_closed != 0, "cap not closed"));
        let tightness = cap.cap_holding_n_m / cap.cap_friction_n_m;
        Self {
            failure,
            tightness: if engaged { tightness } else { 0.0 },
            tilt_rad: bottle.tilt_rad,
        }
    }
}

fn of(part: &str, harm: Option<String>) -> Option<String> {
    harm.map(|harm| format!("{part} {harm}"))
}

fn stands(bottle: &ObjectTruth) -> bool {
    bottle.tilt_rad.abs() <= STANDING_RAD && bottle.table_n > 0.0
}
