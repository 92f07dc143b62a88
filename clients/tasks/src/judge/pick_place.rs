//! Evaluation of pick and place: position of the object, height of its release, and the force that
//! presses it onto its support.
//!
//! The latency starts when the support carries the object
//! ([`shm_schemas::ObjectTruth::carried_ns`]: 0.2 N or a tenth of the weight, sustained). It ends
//! when the hand begins to open; the time until the last contact ends is measured separately.

use shm_schemas::{GoalState, GoalUpdate, ObjectTruth, WorldTruth};

use super::{failure_unless, goal_failure, harm, in_hand_failure};

/// Largest horizontal distance from the destination, m (acceptance criterion).
const POSITION_ERROR_MAX_M: f64 = 0.005;
/// Largest force that presses the object onto its support, N (acceptance criterion).
const PRESSED_DOWN_MAX_N: f64 = 1.0;
/// Largest height above the support at release, m (acceptance criterion).
const RELEASE_HEIGHT_MAX_M: f64 = 0.002;
/// Result of a pick and place.
#[derive(Clone, Debug, PartialEq)]
pub struct Placing {
    /// Failure key.
    pub failure: Option<String>,
    /// Horizontal distance from the destination, m.
    pub off_m: f64,
    /// Time from support to the beginning of the release, s; 0 if negative, infinite if never.
    pub latency_s: f64,
    /// Time from support to the end of contact, s; limits as for `latency_s`.
    pub parting_s: f64,
    /// Height above the support at the end of contact, m.
    pub released_above_m: f64,
    /// Largest force with which the hand pressed the object onto its support, N.
    pub pressed_down_n: f64,
}

impl Placing {
    /// Evaluates the first object with destination `to_m` (x, y, base frame). `let_go_ns`: time at
    /// which the hand began to open.
    #[must_use]
    pub fn evaluate(
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
        let failure = harm(object)
            .or_else(|| failure_unless(!is_left_behind(end, object), "left behind"))
            .or_else(|| goal_failure(end))
            .or_else(|| failure_unless(parting_s.is_finite(), "never released"))
            .or_else(|| failure_unless(above_m <= RELEASE_HEIGHT_MAX_M, "released early"))
            .or_else(|| {
                let is_gentle = object.pressed_down_n <= PRESSED_DOWN_MAX_N;
                failure_unless(is_gentle, "pressed onto its support")
            })
            .or_else(|| failure_unless(off_m <= POSITION_ERROR_MAX_M, "off its place"))
            .or_else(|| in_hand_failure(object));
        Self {
            failure,
            off_m,
            latency_s,
            parting_s,
            released_above_m: above_m,
            pressed_down_n: object.pressed_down_n,
        }
    }
}

/// Returns true if the hand left without the object: not refused, never set down, and at its
/// initial height.
fn is_left_behind(end: &GoalUpdate, object: &ObjectTruth) -> bool {
    let is_low = object.lifted_m.abs() < RELEASE_HEIGHT_MAX_M;
    let set_out = end.state == GoalState::SUCCEEDED || !end.step.as_str().is_empty();
    set_out && end.state != GoalState::REFUSED && object.landed_ns == 0 && is_low
}
