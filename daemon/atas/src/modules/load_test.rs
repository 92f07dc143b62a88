//! Proof of the lift (ours, not in the paper): whether what the hand lifts hangs or still stands.
//!
//! Forces alone cannot tell: an object that slides evenly through the fingers loads them as steadily as one that hangs. So
//! once the hand has travelled far enough for anything that it holds to have left its support, it tugs back a little. An
//! object that hangs keeps its load; one that still stands gives it back to its support. Then the fingers press harder
//! and the hand tries again; where they already press with F_2, the object is refused as too heavy.
//!
//! What hangs at once is tried a second time, because nothing is known of its friction but what the sensor says: there, just
//! above its support, where a slip costs a millimetre, the hand waits until the grip is as gentle as it gets, and tugs again.
//! What falls meanwhile, or stands then, is gripped harder. This is how a grip is found that does not depend on the reading of
//! a friction coefficient.

use super::fall::Fall;
use super::force_limit::too_heavy;
use super::{
    Context, Finding, Module, Proposal, RELEASE_SHARE, Verdict, force_range_n, force_up_n, load_n,
};
use crate::perception::Percept;
use robot_model::VIRTUAL_FINGERS;
use shm_schemas::ModuleId;

/// How far the tug goes back, m (ours: beyond what the rim of a patch stretches, well below what was lifted before).
const TUG_M: f64 = 0.0004;
/// Share of the load that an object must keep during the tug to count as hanging (ours).
const HANGING_SHARE: f64 = 0.6;
/// Load below which a tug tells nothing, N (ours: the noise of two fingertips).
const LOAD_FLOOR_N: f64 = 0.03;

/// Frames that must have come since the hand is back that far: the first may have been sensed before (ours).
const FRAMES: u32 = 2;

/// Opening speed of a finger below which the grip is as gentle as it gets, m/s, and how long it must be, s (ours: longer than
/// a grip must be steady before it is relaxed).
const STILL_M_S: f64 = 0.0002;
const STILL_S: f64 = 0.3;
/// Longest time that the gentlest grip is waited for, s (ours).
const TRY_MAX_S: f64 = 3.0;

/// What the module remembers of one lift.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct LoadTest {
    phase: Phase,
    /// The gentlest grip has been tried, or will not be: the next proof is the last.
    tried: bool,
}

#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
enum Phase {
    /// The lift has not begun.
    #[default]
    Ready,
    /// The hand travels until it has carried the object this far, m.
    Travelling(f64),
    /// The hand tugs back.
    Tugging(Tug),
    /// It hangs: the hand waits until the grip has been relaxed.
    Trying(Trying),
    /// It stands: the fingers press until the weakest has this force, N.
    Pressing(f64),
    /// It hangs.
    Hangs,
}

/// The gentlest grip being found.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
struct Trying {
    /// How far the hand carries it before, m: it has sunk during the tug.
    from_m: f64,
    /// How long the fingers have been still, and how long it has lasted, s.
    still_s: f64,
    total_s: f64,
    /// Its load since it hangs.
    fall: Fall,
}

/// One tug.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
struct Tug {
    /// Where it began, m of carrying.
    from_m: f64,
    /// Load before it, N.
    load_n: f64,
    /// Least load since, N.
    least_n: f64,
    /// Frames since the hand is back far enough.
    frames: u32,
}

impl Module for LoadTest {
    const ID: ModuleId = ModuleId::LOAD_TEST;

    fn evaluate(&mut self, percept: &Percept, context: &Context<'_>) -> Proposal {
        let settings = &context.settings.grasp;
        let (weakest_n, strongest_n) = force_range_n(percept);
        let at_ceiling = strongest_n > RELEASE_SHARE * context.thresholds.f2_n;
        let stands = self.follow(percept, context, weakest_n, at_ceiling);
        let reason = too_heavy(strongest_n, context);
        let (closing_m_s, carry_ceiling) = match self.phase {
            Phase::Tugging(tug) if tug.frames == 0 => (0.0, -1.0),
            Phase::Tugging(_) => (0.0, 0.0),
            Phase::Trying(trying) if trying.has_begun(context.carried_m) => (0.0, 0.0),
            Phase::Pressing(_) => (settings.enhance_m_s, 0.0),
            _ => (0.0, 1.0),
        };
        Proposal {
            active: carry_ceiling < 1.0,
            closing_m_s: [closing_m_s; VIRTUAL_FINGERS],
            carry_ceiling,
            verdict: if stands && at_ceiling {
                Verdict::Refuse(reason.by(ModuleId::LOAD_TEST))
            } else {
                Verdict::None
            },
            finding: Finding {
                slides: stands,
                hangs: self.phase == Phase::Hangs,
                tries: matches!(self.phase, Phase::Trying(t) if t.has_begun(context.carried_m)),
            },
            ..Proposal::default()
        }
    }
}

impl LoadTest {
    /// Goes on to the next phase; true in the tick in which a tug finds that the object stands.
    fn follow(
        &mut self,
        percept: &Percept,
        context: &Context<'_>,
        weakest_n: f64,
        at_ceiling: bool,
    ) -> bool {
        let settings = &context.settings.grasp;
        let carried_m = context.carried_m;
        match &mut self.phase {
            Phase::Ready => self.phase = Phase::Travelling(settings.load_test_travel_m),
            Phase::Travelling(until_m) if carried_m > *until_m => {
                self.phase = Phase::Tugging(Tug::begin(carried_m, load_n(percept)));
            }
            Phase::Tugging(tug) => match tug.hangs(percept, carried_m) {
                Some(true) if self.tried => self.phase = Phase::Hangs,
                Some(true) => {
                    let trying = Trying {
                        from_m: tug.from_m,
                        ..Trying::default()
                    };
                    (self.phase, self.tried) = (Phase::Trying(trying), true);
                }
                Some(false) => {
                    let until_n = weakest_n * settings.load_test_press;
                    (self.phase, self.tried) = (Phase::Pressing(until_n), true);
                    return true;
                }
                None => {}
            },
            Phase::Trying(trying) => {
                let down_n = -force_up_n(percept, context.base_from_tip);
                let shaken = !trying.has_begun(carried_m);
                if trying.fall.follow(Some(down_n), shaken, percept.step_s) {
                    self.phase = Phase::Pressing(weakest_n * settings.load_test_press);
                    return true;
                }
                if trying.is_over(context) {
                    self.phase = Phase::Tugging(Tug::begin(carried_m, load_n(percept)));
                }
            }
            Phase::Pressing(until_n) if weakest_n > *until_n || at_ceiling => {
                self.phase = Phase::Travelling(carried_m + settings.load_test_travel_m / 2.0);
            }
            _ => {}
        }
        false
    }
}

impl Trying {
    fn has_begun(&self, carried_m: f64) -> bool {
        self.total_s > 0.0 || carried_m > self.from_m
    }

    /// Whether the fingers have found the gentlest grip.
    fn is_over(&mut self, context: &Context<'_>) -> bool {
        if !self.has_begun(context.carried_m) {
            return false;
        }
        let moves = |closing_m_s: &f64| closing_m_s.abs() > STILL_M_S;
        self.total_s += context.step_s;
        self.still_s = if context.closing_m_s.iter().any(moves) {
            0.0
        } else {
            self.still_s + context.step_s
        };
        self.still_s > STILL_S || self.total_s > TRY_MAX_S
    }
}

impl Tug {
    fn begin(from_m: f64, load_n: f64) -> Self {
        Self {
            from_m,
            load_n,
            least_n: load_n,
            frames: 0,
        }
    }

    /// Whether the object hangs, once the hand is back far enough and has felt it there.
    fn hangs(&mut self, percept: &Percept, carried_m: f64) -> Option<bool> {
        let load_n = load_n(percept);
        if load_n < self.least_n {
            self.least_n = load_n;
        }
        let back = self.frames > 0 || self.from_m - carried_m > TUG_M;
        if back && percept.step_s > 0.0 {
            self.frames += 1;
        }
        let keeps = self.load_n < LOAD_FLOOR_N || self.least_n >= HANGING_SHARE * self.load_n;
        (self.frames > FRAMES).then_some(keeps)
    }
}
