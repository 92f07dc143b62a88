//! Pick and place: where the object stands, and when and how high above its place it was let go.

use shm_schemas::{GoalUpdate, ObjectTruth, WorldTruth};

use super::{ended, harmed, unless};

/// Farthest that an object may stand from its place, horizontally, m (issue).
const OFF_M: f64 = 0.005;
/// Longest time from support to release, s (issue).
const LATENCY_S: f64 = 0.020;
/// Highest above its support that an object may be let go, m (issue).
const ABOVE_M: f64 = 0.002;
/// Force with which a support truly carries, N, or the share of the weight, whichever is more (issue). A first corner
/// that grazes carries less.
const CARRIES_N: f64 = 0.2;
const CARRIES_SHARE: f64 = 0.1;

/// Watches for the moment at which an object's new place truly carries it.
#[derive(Clone, Copy, Debug)]
pub struct Support {
    carries_n: f64,
    since_ns: Option<u64>,
}

impl Support {
    /// Of an object of this weight, N.
    #[must_use]
    pub fn of(weight_n: f64) -> Self {
        Self {
            carries_n: CARRIES_N.max(CARRIES_SHARE * weight_n),
            since_ns: None,
        }
    }

    /// Looks at the truth of a tick. Call on every tick: the moment is only as exact as the looks are frequent.
    pub fn look(&mut self, object: &ObjectTruth, now_ns: u64) {
        if self.since_ns.is_none() && object.landed_ns > 0 && object.table_n >= self.carries_n {
            self.since_ns = Some(now_ns);
        }
    }

    /// The moment, simulated time, ns; `None` if it has not come.
    #[must_use]
    pub fn since_ns(&self) -> Option<u64> {
        self.since_ns
    }
}

/// What became of a pick and place.
#[derive(Clone, Debug, PartialEq)]
pub struct Placing {
    /// Why it is no success; `None` if it is.
    pub failure: Option<String>,
    /// Horizontal distance of the object from its place, m.
    pub off_m: f64,
    /// From support to release, s; 0 if it was let go before it was carried, infinite if never.
    pub latency_s: f64,
    /// Height above its support at which it was let go, m.
    pub released_above_m: f64,
}

impl Placing {
    /// Of the first object, whose place is `to_m` (x, y, base frame). `carried_ns` is the moment of [`Support`]; without one
    /// the first touch of the support counts, which is earlier.
    #[must_use]
    pub fn of(
        end: &GoalUpdate,
        truth: &WorldTruth,
        to_m: [f64; 2],
        carried_ns: Option<u64>,
    ) -> Self {
        let object = &truth.objects[0];
        let [x_m, y_m, _] = object.position_m;
        let off_m = (x_m - to_m[0]).hypot(y_m - to_m[1]);
        let carried_ns = carried_ns.unwrap_or(object.landed_ns);
        let let_go = object.landed_ns > 0 && object.released_ns > 0;
        let latency_s = if let_go {
            object.released_ns.saturating_sub(carried_ns) as f64 * 1e-9
        } else {
            f64::INFINITY
        };
        let above_m = object.released_above_m;
        let failure = harmed(object)
            .or_else(|| ended(end))
            .or_else(|| unless(let_go, "never released"))
            .or_else(|| unless(above_m <= ABOVE_M, "released early"))
            .or_else(|| unless(latency_s <= LATENCY_S, "released late"))
            .or_else(|| unless(off_m <= OFF_M, "off its place"));
        Self {
            failure,
            off_m,
            latency_s,
            released_above_m: above_m,
        }
    }
}
