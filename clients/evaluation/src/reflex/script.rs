//! A policy as clumsy as they come: ten targets a second, each 50 ms late, in steps and with a trembling aim; half of them close
//! too weakly to hold anything, half much too hard. It knows where the object was meant to stand, and feels nothing.

use shm_schemas::{GraspTarget, GripOrder, Hand, Stamp};
use sim_backend::GraspHint;
use sim_backend::random::Random;

/// Ticks between two targets (10 Hz), and from the making of one to its arrival (issue).
const PERIOD_TICKS: u64 = 100;
pub(super) const LATENCY_TICKS: u64 = 50;
/// How long a target may be followed, ns (ours: three periods and the latency).
const VALID_NS: u64 = 350_000_000;
/// Extra opening before the object, m (ours: 9 mm on each side).
const OPEN_BY_M: f64 = 0.018;
/// Height of the way to the object and of the lift above the grasp, m (ours).
const OVER_M: f64 = 0.06;
pub(super) const LIFT_M: f64 = 0.04;
/// How far the object is carried aside, m (ours).
const ASIDE_M: f64 = 0.06;
/// Half widths of the jerks: of the centre, m, and of the yaw, rad (ours: 2 mm and 3° every tenth of a second).
const JERK_M: f64 = 0.002;
const JERK_RAD: f64 = 0.05;
/// How far the policy closes beyond the object's width, m: too weakly, and too hard (ours: a quarter of a millimetre of skin on
/// each side holds next to nothing; two millimetres on each side crush what can be crushed).
const WEAK_M: [f64; 2] = [0.0003, 0.0008];
const HARD_M: [f64; 2] = [0.003, 0.006];
/// When each phase ends, s (ours: a patient policy would take as long): over the object, down, closed, lifted, aside, done.
const PHASES_S: [f64; 6] = [2.5, 4.5, 9.0, 12.0, 14.5, 16.0];

/// The policy in one trial.
#[derive(Clone, Debug)]
pub struct Script {
    hint: GraspHint,
    hand: Hand,
    width_m: f64,
    weakly: bool,
    random: Random,
    sequence: u64,
}

impl Script {
    /// A policy for an object; every second seed closes too weakly.
    #[must_use]
    pub fn new(hint: GraspHint, hand: Hand, weakly: bool, mut random: Random) -> Self {
        let [least_m, most_m] = if weakly { WEAK_M } else { HARD_M };
        let by_m = random.between(least_m, most_m);
        Self {
            width_m: hint.width_m - by_m,
            hint,
            hand,
            weakly,
            random,
            sequence: 0,
        }
    }

    /// Whether it closes too weakly.
    #[must_use]
    pub fn is_weak(&self) -> bool {
        self.weakly
    }

    /// How long it takes, ticks.
    #[must_use]
    pub fn ticks() -> u64 {
        (PHASES_S[5] * 1e3) as u64
    }

    /// The target that is made in this tick, if one is.
    pub fn make(&mut self, tick: u64, now_ns: u64, writer_epoch: u64) -> Option<GraspTarget> {
        if !tick.is_multiple_of(PERIOD_TICKS) {
            return None;
        }
        let time_s = tick as f64 * 1e-3;
        let phase = PHASES_S.iter().position(|end_s| time_s < *end_s)?;
        let [x_m, y_m, z_m] = self.hint.from_m;
        let (aside_m, up_m, opening_m) = match phase {
            0 => (0.0, OVER_M, self.hint.width_m + OPEN_BY_M),
            1 => (0.0, 0.0, self.hint.width_m + OPEN_BY_M),
            2 => (0.0, 0.0, self.width_m),
            3 => (0.0, LIFT_M, self.width_m),
            _ => (ASIDE_M, LIFT_M, self.width_m),
        };
        let mut jerk = |half: f64| self.random.between(-half, half);
        // Down into the table no policy would aim, and close by it not at all.
        let centre_m = [
            x_m + jerk(JERK_M),
            y_m - aside_m + jerk(JERK_M),
            z_m + up_m + jerk(JERK_M).max(0.0),
        ];
        let closing_yaw_rad = self.hint.yaw_rad + jerk(JERK_RAD);
        let mut target = GraspTarget {
            stamp: Stamp {
                sequence: self.sequence,
                captured_ns: now_ns,
                writer_epoch,
            },
            valid_until_ns: now_ns + VALID_NS,
            hand: self.hand,
            grip: GripOrder::WIDTH,
            centre_m,
            closing_yaw_rad,
            opening_m,
            ..GraspTarget::default()
        };
        target.seal();
        self.sequence += 1;
        Some(target)
    }
}
