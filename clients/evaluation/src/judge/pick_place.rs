//! Pick and place: where the object stands, and when and how high above its place it was let go.
//!
//! The latency runs from the moment at which the support truly carries ([`shm_schemas::ObjectTruth::carried_ns`]: 0.2 N or
//! a tenth of the weight, and not for an instant only) to the moment at which the hand begins to open. Until the last
//! fingertip has left it takes as long as a squeezed hand needs to open, which is measured besides.

use shm_schemas::{GoalState, GoalUpdate, ObjectTruth, WorldTruth};

use super::{ended, harmed, moved_in_hand, unless};

/// Farthest that an object may stand from its place, horizontally, m (issue).
const OFF_M: f64 = 0.005;
/// Longest time from support to the beginning of the release, s (issue).
const LATENCY_S: f64 = 0.020;
/// Highest above its support that an object may be let go, m (issue).
const ABOVE_M: f64 = 0.002;
/// What became of a pick and place.
#[derive(Clone, Debug, PartialEq)]
pub struct Placing {
    /// Why it is no success; `None` if it is.
    pub failure: Option<String>,
    /// Horizontal distance of the object from its place, m.
    pub off_m: f64,
    /// From support to the beginning of the release, s; 0 if the hand opened before, infinite if it never did.
    pub latency_s: f64,
    /// From support until the last fingertip has left, s; 0 and infinite as before.
    pub parting_s: f64,
    /// Height above its support at which the last fingertip left it, m.
    pub released_above_m: f64,
}

impl Placing {
    /// Of the first object, whose place is `to_m` (x, y, base frame). `let_go_ns` is when the hand began to let go, on the
    /// clock of the truth.
    #[must_use]
    pub fn of(
        end: &GoalUpdate,
        truth: &WorldTruth,
        to_m: [f64; 2],
        let_go_ns: Option<u64>,
    ) -> Self {
        let object = &truth.objects[0];
        let [x_m, y_m, _] = object.position_m;
        let off_m = libm::hypot(x_m - to_m[0], y_m - to_m[1]);
        let carried_ns = (object.carried_ns > 0).then_some(object.carried_ns);
        let since = |ns: Option<u64>| match (carried_ns, ns) {
            (Some(carried_ns), Some(ns)) => ns.saturating_sub(carried_ns) as f64 * 1e-9,
            _ => f64::INFINITY,
        };
        let latency_s = since(let_go_ns);
        let parting_s = since((object.released_ns > 0).then_some(object.released_ns));
        let above_m = object.released_above_m;
        let failure = harmed(object)
            .or_else(|| unless(!stayed(end, object), "left behind"))
            .or_else(|| ended(end))
            .or_else(|| unless(parting_s.is_finite(), "never released"))
            .or_else(|| unless(above_m <= ABOVE_M, "released early"))
            .or_else(|| unless(latency_s <= LATENCY_S, "released late"))
            .or_else(|| unless(off_m <= OFF_M, "off its place"))
            .or_else(|| moved_in_hand(object));
        Self {
            failure,
            off_m,
            latency_s,
            parting_s,
            released_above_m: above_m,
        }
    }
}

/// Whether the hand left without the object: set out and not refused, never set down, and as low as it was.
fn stayed(end: &GoalUpdate, object: &ObjectTruth) -> bool {
    let is_low = object.lifted_m.abs() < ABOVE_M;
    let set_out = end.state == GoalState::SUCCEEDED || !end.step.as_str().is_empty();
    set_out && end.state != GoalState::REFUSED && object.landed_ns == 0 && is_low
}
