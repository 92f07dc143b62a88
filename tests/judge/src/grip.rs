//! Object that the hand must keep, by ground truth.

use shm_schemas::{ObjectTruth, WorldTruth};

use crate::findings::{Findings, ViolationKind};
use crate::objects::objects;

/// Largest additional slip in the hand while the grip must be kept, m. Acceptance criterion of the
/// tasks; smaller values reject normal settling of the grip, larger ones hide a slow slide.
pub const GRIP_SLIP_MAX_M: f64 = 0.003;
/// Largest additional turn in the hand while the grip must be kept, rad (10°). Acceptance criterion
/// of the tasks; smaller values reject settling, larger ones hide a slow turn.
pub const GRIP_TURN_MAX_RAD: f64 = 10.0 * std::f64::consts::PI / 180.0;

/// Reason why a grip cannot be expected.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum GripError {
    /// No such object in the last ground truth.
    #[error(
        "grip not judged: object {index} does not exist, the world has {count}; observe a tick \
         first, and give an index below that"
    )]
    UnknownObject {
        /// Index.
        index: usize,
        /// Number of objects.
        count: usize,
    },
    /// The object stands, or no fingertip presses it.
    #[error(
        "grip not judged: object {index} is not in the hand (lifted {lifted_m} m, pressed \
         {pressed}); expect the grip after the lift"
    )]
    NotHeld {
        /// Index.
        index: usize,
        /// Height above its initial rest height, m.
        lifted_m: f64,
        /// 1 while a fingertip presses the object.
        pressed: u32,
    },
}

/// Object in the hand at the start of the expectation.
#[derive(Clone, Copy, Debug)]
struct Held {
    index: usize,
    start: ObjectTruth,
}

/// Check of the grip; ends with its first violation.
#[derive(Clone, Debug, Default)]
pub(crate) struct GripCheck {
    held: Option<Held>,
}

impl GripCheck {
    /// Begins to check an object that a hand has lifted.
    pub(crate) fn expect(&mut self, index: usize, truth: &WorldTruth) -> Result<(), GripError> {
        let known = objects(truth);
        let count = known.len();
        let Some(start) = known.get(index).copied() else {
            return Err(GripError::UnknownObject { index, count });
        };
        let is_lifted = start.lifted_m > 0.0;
        if !is_lifted || start.pressed == 0 {
            return Err(GripError::NotHeld {
                index,
                lifted_m: start.lifted_m,
                pressed: start.pressed,
            });
        }
        self.held = Some(Held { index, start });
        Ok(())
    }

    pub(crate) fn release(&mut self) {
        self.held = None;
    }

    pub(crate) fn check(&mut self, truth: &WorldTruth, findings: &mut Findings) {
        let Some(held) = self.held else { return };
        let kept = match objects(truth).get(held.index) {
            None => lost(&held, "it does not exist any more", findings),
            Some(now) => held.check(now, findings),
        };
        if !kept {
            self.held = None;
        }
    }
}

impl Held {
    fn check(&self, now: &ObjectTruth, findings: &mut Findings) -> bool {
        let start = &self.start;
        let losses = [
            (now.dropped > start.dropped, "it was dropped"),
            (now.crushed > start.crushed, "it was crushed"),
            (now.tipped > start.tipped, "it tipped over"),
            (now.pressed == 0, "no fingertip presses it"),
        ];
        let mut kept = true;
        for (_, loss) in losses.iter().filter(|(is_lost, _)| *is_lost) {
            kept = lost(self, loss, findings);
        }
        self.check_motion(now, findings) && kept
    }

    /// Checks slip and turn since the start of the expectation.
    fn check_motion(&self, now: &ObjectTruth, findings: &mut Findings) -> bool {
        let slip_m = now.slip_in_hand_m - self.start.slip_in_hand_m;
        let turn_rad = now.turn_in_hand_rad - self.start.turn_in_hand_rad;
        // Both are false for NaN.
        let (sticks, keeps_angle) = (slip_m <= GRIP_SLIP_MAX_M, turn_rad <= GRIP_TURN_MAX_RAD);
        let index = self.index;
        if !sticks {
            findings.report(
                ViolationKind::GripSlip,
                format_args!("object {index} slid by {slip_m} m, limit {GRIP_SLIP_MAX_M} m"),
            );
        }
        if !keeps_angle {
            findings.report(
                ViolationKind::GripTurn,
                format_args!("object {index} turned by {turn_rad} rad, limit {GRIP_TURN_MAX_RAD}"),
            );
        }
        sticks && keeps_angle
    }
}

/// Reports a loss; returns false.
fn lost(held: &Held, loss: &str, findings: &mut Findings) -> bool {
    findings.report(
        ViolationKind::GripLost,
        format_args!(
            "the hand does not keep object {} ({}): {loss}",
            held.index, held.start.name
        ),
    );
    false
}
