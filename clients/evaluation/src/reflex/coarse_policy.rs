//! Coarse position policy without tactile feedback: ten targets per second, each 50 ms late, in
//! steps with position jitter. Half of the policies close too weakly, half too strongly. The
//! object's place is nominal knowledge.

use shm_schemas::{GraspTarget, GripOrder, Hand, Stamp};
use sim_backend::GraspHint;
use sim_backend::random::Random;

/// Period of the targets (10 Hz) and their latency, ticks (acceptance criterion).
const PERIOD_TICKS: u64 = 100;
pub(super) const LATENCY_TICKS: u64 = 50;
/// Validity of a target, ns. Design choice: three periods plus latency.
const VALID_NS: u64 = 350_000_000;
/// Additional opening in the approach, m. Design choice: 9 mm per side.
const APPROACH_OPENING_M: f64 = 0.018;
/// Height above the grasp of the approach and of the lift, m. Design choice.
const APPROACH_HEIGHT_M: f64 = 0.06;
pub(super) const LIFT_M: f64 = 0.04;
/// Lateral distance of the carry, m. Design choice.
const LATERAL_M: f64 = 0.06;
/// Half widths of the jitter per target: centre (m), yaw (rad). Design choice: 2 mm and 3°.
const JITTER_M: f64 = 0.002;
const JITTER_RAD: f64 = 0.05;
/// Commanded closing beyond the object's width, m: too weak and too strong. Design choice: 0.25 mm
/// per side hold almost no load, 2 mm crush fragile objects.
const WEAK_M: [f64; 2] = [0.0003, 0.0008];
const HARD_M: [f64; 2] = [0.003, 0.006];
/// End of each phase, s: above the object, down, closed, lifted, moved aside, done. Design choice:
/// the speed of a careful policy.
const PHASES_S: [f64; 6] = [2.5, 4.5, 9.0, 12.0, 14.5, 16.0];

/// Policy of one trial.
#[derive(Clone, Debug)]
pub struct CoarsePolicy {
    hint: GraspHint,
    hand: Hand,
    width_m: f64,
    weakly: bool,
    random: Random,
    sequence: u64,
}

impl CoarsePolicy {
    /// Creates a policy for an object; `weakly` selects the too weak closing.
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

    /// Returns true if the policy closes too weakly.
    #[must_use]
    pub fn is_weak(&self) -> bool {
        self.weakly
    }

    /// Returns the duration, ticks.
    #[must_use]
    pub fn ticks() -> u64 {
        (PHASES_S[5] * 1e3) as u64
    }

    /// Returns the target created in this tick, if any.
    pub fn target(&mut self, tick: u64, now_ns: u64, writer_epoch: u64) -> Option<GraspTarget> {
        if !tick.is_multiple_of(PERIOD_TICKS) {
            return None;
        }
        let time_s = tick as f64 * 1e-3;
        let phase = PHASES_S.iter().position(|end_s| time_s < *end_s)?;
        let [x_m, y_m, z_m] = self.hint.from_m;
        let (aside_m, up_m, opening_m) = match phase {
            0 => (
                0.0,
                APPROACH_HEIGHT_M,
                self.hint.width_m + APPROACH_OPENING_M,
            ),
            1 => (0.0, 0.0, self.hint.width_m + APPROACH_OPENING_M),
            2 => (0.0, 0.0, self.width_m),
            3 => (0.0, LIFT_M, self.width_m),
            _ => (LATERAL_M, LIFT_M, self.width_m),
        };
        let mut jerk = |half: f64| self.random.between(-half, half);
        // The jitter never lowers the target into the table.
        let centre_m = [
            x_m + jerk(JITTER_M),
            y_m - aside_m + jerk(JITTER_M),
            z_m + up_m + jerk(JITTER_M).max(0.0),
        ];
        let closing_yaw_rad = self.hint.yaw_rad + jerk(JITTER_RAD);
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
