//! Motion in the hand that a reported success hides.

use serde::{Deserialize, Serialize};
use shm_schemas::{GoalState, GoalUpdate, WorldTruth};

use super::{SLIP_MAX_M, TURN_MAX_RAD};

/// Motion of an object in the hand beyond its limit, although the controller reported success. The
/// motion counts from lift-off, when the support no longer carries the whole weight.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct HiddenMotion {
    /// An object slid more than [`SLIP_MAX_M`].
    pub slid: bool,
    /// An object turned more than [`TURN_MAX_RAD`].
    pub turned: bool,
}

impl HiddenMotion {
    /// Compares all objects with the limits; a value that is not finite exceeds them. Without a
    /// reported success, nothing is hidden.
    #[must_use]
    pub fn evaluate(end: &GoalUpdate, truth: &WorldTruth) -> Self {
        if end.state != GoalState::SUCCEEDED {
            return Self::default();
        }
        let objects = &truth.objects[..truth.object_count as usize];
        Self {
            slid: !objects.iter().all(|o| o.slip_in_hand_m <= SLIP_MAX_M),
            turned: !objects.iter().all(|o| o.turn_in_hand_rad <= TURN_MAX_RAD),
        }
    }
}
