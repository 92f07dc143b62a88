//! Lift verification (not in the paper): detects whether a lifted object is suspended or still
//! stands.
//!
//! Forces alone do not show this: a uniformly slipping object gives the same steady load as a
//! suspended one. After enough travel for any held object to leave its support, the hand pulls back
//! slightly. A suspended object keeps its load; a standing one transfers it to the support, and
//! then pushes the fingertips up. The fingers then close further and the lift is repeated. At F_2,
//! the object is refused as too heavy.
//!
//! The friction of an object that is suspended at first is known only from the sensor. Just above
//! the support, where a slip costs a millimetre, the hand minimises the grip and pulls back again.
//! If the object drops or stands, the grip is increased. The resulting grip does not depend on a
//! friction reading. At the limit of friction, a shake would start a slide that kinetic friction
//! does not stop. The fingers therefore close to a utilisation of `SECURED_UTILISATION` first.

use super::{Context, Module, Proposal, RELEASE_SHARE, Verdict};
use crate::filter::Dwell;
use crate::held_object::LiftFinding;
use crate::perception::Percept;
use robot_model::PerSide;
use shm_schemas::ModuleId;

/// Largest lifting distance from the begin of a slip until the hand can respond, m. Design choice:
/// sensors of 200 Hz and more allow `motion.lift_m_s`.
const SLIP_TRAVEL_M: f64 = 0.0001;
/// Pull-back distance, m (design choice: more than the elastic stretch of a patch rim, less than
/// the lift).
const PULL_BACK_M: f64 = 0.0004;
/// Share of the load that a suspended object keeps during the pull-back (design choice).
const SUSPENDED_SHARE: f64 = 0.6;
/// Load below which a pull-back gives no result, N (design choice: noise of two fingertips).
const LOAD_FLOOR_N: f64 = 0.03;

/// Number of frames in the mean load before and after the pull-back (design choice: at 1 kHz the
/// low-pass on the elements averages as many; single frames at 100 Hz misjudge light objects).
const FRAMES: u32 = 5;

/// Finger speed, m/s, and its duration, s, that end grip minimisation (design choice: longer than
/// the steady time of grip relaxation).
const STILL_M_S: f64 = 0.0002;
const STILL_S: f64 = 0.3;
/// Friction utilisation at which a minimised grip is verified. Design choice: kinetic friction is a
/// tenth lower than static friction, and the load trembles by a few per cent.
const SECURED_UTILISATION: f64 = 0.84;
/// Timeout of grip minimisation, s (design choice).
const MINIMISE_MAX_S: f64 = 3.0;

#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct LiftVerification {
    phase: Phase,
    /// Grip minimisation is done or skipped; the next success is final.
    minimised: bool,
}

#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
enum Phase {
    #[default]
    Ready,
    /// The hand travels until this carried distance, m.
    Travelling(f64),
    PullingBack(PullBack),
    /// The object is suspended; the hand waits for the minimum grip.
    Minimising(GripMinimisation),
    /// The minimised grip holds the object; the fingers close until the weaker side reaches this
    /// force, N.
    Securing(f64),
    /// The object stands; the fingers close until the weaker side reaches this force, N.
    Pressing(f64),
    Suspended,
}

#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
struct GripMinimisation {
    /// Carried distance to restore after the pull-back, m.
    from_m: f64,
    /// Time without finger motion, and total time, s.
    still: Dwell,
    total_s: f64,
}

#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
struct PullBack {
    /// Carried distance at its start, m.
    from_m: f64,
    /// Vertical loads before and after it.
    before: Mean,
    after: Mean,
    /// The pull-back distance is reached.
    is_back: bool,
}

/// Mean of the load over several frames.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
struct Mean {
    sum_n: f64,
    frames: u32,
}

impl Module for LiftVerification {
    const ID: ModuleId = ModuleId::LIFT_VERIFICATION;

    fn evaluate(&mut self, percept: &Percept, context: &Context<'_>) -> Proposal {
        let settings = &context.settings.grasp;
        let (weakest_n, strongest_n) = percept.normal_range_n();
        let at_ceiling = strongest_n > RELEASE_SHARE * context.object.thresholds.f2_n;
        let stands = self.advance(percept, context, weakest_n, at_ceiling);
        let thresholds = &context.object.thresholds;
        let (closing_m_s, carry_ceiling) = match self.phase {
            Phase::PullingBack(tug) if tug.is_moving() => (0.0, -1.0),
            Phase::PullingBack(_) => (0.0, 0.0),
            Phase::Minimising(trying) if trying.has_begun(context.object.carried_m) => (0.0, 0.0),
            Phase::Securing(_) | Phase::Pressing(_) => (settings.enhance_m_s, 0.0),
            Phase::Travelling(_) => {
                let gentle_m_s = percept.touch_speed_m_s(SLIP_TRAVEL_M, 1, context.settings);
                (
                    0.0,
                    (gentle_m_s / context.settings.motion.lift_m_s).min(1.0),
                )
            }
            _ => (0.0, 1.0),
        };
        Proposal {
            active: carry_ceiling < 1.0,
            closing_m_s: PerSide::repeat(closing_m_s),
            carry_ceiling,
            verdict: if stands && at_ceiling {
                Verdict::Refuse(thresholds.refusal(strongest_n, Self::ID))
            } else {
                Verdict::None
            },
            finding: match self.phase {
                _ if stands => LiftFinding::Standing,
                Phase::Minimising(trial) if trial.has_begun(context.object.carried_m) => {
                    LiftFinding::MinimisesGrip
                }
                Phase::Suspended => LiftFinding::Suspended,
                _ => LiftFinding::None,
            },
            ..Proposal::default()
        }
    }
}

impl LiftVerification {
    /// Advances the phase; true in the tick in which the object stands or drops.
    fn advance(
        &mut self,
        percept: &Percept,
        context: &Context<'_>,
        weakest_n: f64,
        at_ceiling: bool,
    ) -> bool {
        let settings = &context.settings.grasp;
        let carried_m = context.object.carried_m;
        match &mut self.phase {
            Phase::Ready => self.phase = Phase::Travelling(settings.verification_travel_m),
            Phase::Travelling(until_m) if carried_m > *until_m => {
                self.phase = Phase::PullingBack(PullBack::new(carried_m));
            }
            Phase::PullingBack(tug) => match tug.is_suspended(percept, context) {
                Some(true) if self.minimised => self.phase = Phase::Suspended,
                Some(true) => {
                    let trying = GripMinimisation {
                        from_m: tug.from_m,
                        ..GripMinimisation::default()
                    };
                    (self.phase, self.minimised) = (Phase::Minimising(trying), true);
                }
                Some(false) => {
                    let until_n = weakest_n * settings.verification_press;
                    (self.phase, self.minimised) = (Phase::Pressing(until_n), true);
                    return true;
                }
                None => {}
            },
            Phase::Minimising(trying) => {
                if context.object.drops {
                    self.phase = Phase::Pressing(weakest_n * settings.verification_press);
                    return true;
                }
                if trying.is_over(context) {
                    self.phase = Phase::Securing(weakest_n * reserve(percept));
                }
            }
            Phase::Securing(until_n) if weakest_n >= *until_n || at_ceiling => {
                self.phase = Phase::PullingBack(PullBack::new(carried_m));
            }
            Phase::Pressing(until_n) if weakest_n > *until_n || at_ceiling => {
                self.phase = Phase::Travelling(carried_m + settings.verification_travel_m / 2.0);
            }
            _ => {}
        }
        false
    }
}

/// Returns the factor on the grip force that secures a minimised grip against a shake, ≥ 1.
fn reserve(percept: &Percept) -> f64 {
    let used = percept.sides.iter().map(|side| side.utilisation);
    used.fold(SECURED_UTILISATION, f64::max) / SECURED_UTILISATION
}

impl GripMinimisation {
    fn has_begun(&self, carried_m: f64) -> bool {
        self.total_s > 0.0 || carried_m > self.from_m
    }

    fn is_over(&mut self, context: &Context<'_>) -> bool {
        if !self.has_begun(context.object.carried_m) {
            return false;
        }
        let moves = |closing_m_s: &f64| closing_m_s.abs() > STILL_M_S;
        self.total_s += context.step_s;
        let still = !context.hand.closing_m_s.iter().any(moves);
        self.still.update(still, context.step_s);
        self.still.seconds() > STILL_S || self.total_s > MINIMISE_MAX_S
    }
}

impl PullBack {
    fn new(carried_m: f64) -> Self {
        Self {
            from_m: carried_m,
            before: Mean::default(),
            after: Mean::default(),
            is_back: false,
        }
    }

    /// Returns true between both measurements.
    fn is_moving(&self) -> bool {
        self.before.is_complete() && !self.is_back
    }

    /// Returns whether the object is suspended, after enough frames.
    fn is_suspended(&mut self, percept: &Percept, context: &Context<'_>) -> Option<bool> {
        let (down_n, carried_m) = (context.object.down_n, context.object.carried_m);
        if !self.before.is_complete() {
            self.before.add(down_n, percept.step_s);
            self.from_m = carried_m;
        } else if self.is_back {
            self.after.add(down_n, percept.step_s);
        } else {
            self.is_back = self.from_m - carried_m > PULL_BACK_M;
        }
        let (before_n, after_n) = (self.before.mean_n(), self.after.mean_n());
        let keeps = before_n < LOAD_FLOOR_N || after_n >= SUSPENDED_SHARE * before_n;
        self.after.is_complete().then_some(keeps)
    }
}

impl Mean {
    /// Adds the load of a frame that covers `step_s`, zero without a new one.
    fn add(&mut self, load_n: f64, step_s: f64) {
        if step_s > 0.0 {
            self.sum_n += load_n;
            self.frames += 1;
        }
    }

    fn mean_n(&self) -> f64 {
        self.sum_n / f64::from(self.frames)
    }

    fn is_complete(&self) -> bool {
        self.frames >= FRAMES
    }
}
