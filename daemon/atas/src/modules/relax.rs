//! Grip relaxation (not in the paper): reduces force that friction does not need.
//!
//! The paper's grasp ends with a "suitable normal force that generated maximum static friction
//! force", but modules 1 to 3 only add force. The fingers open slowly while the object is
//! suspended, its load is steady (dF_t < dr) and every side's utilisation is below `relax_below`.
//! The force stays above the minimum grip force, and above the force-to-load ratio at which opening
//! last caused closing.
//!
//! A poor sensor may misread friction by more than the grip's margin. In grip minimisation, the
//! fingers therefore open down to `TRY_BELOW`. The verified force is then the minimum.

use super::slip::STEADY_SHARE;
use super::{Context, Module, Proposal, force_range_n, load_n};
use crate::filter::low_pass;
use crate::limits::FRICTION_FLOOR;
use crate::perception::{FingerPercept, Percept};
use robot_model::VIRTUAL_FINGERS;
use shm_schemas::ModuleId;

/// Factor above the minimum force at which opening stops (design choice: keeps Module 1 inactive).
const LEAST_MARGIN: f64 = 1.1;
/// Utilisation margin above which opening runs at full speed (design choice).
const SPARE_FULL: f64 = 0.1;
/// Standard deviations of sensor noise subtracted from the remembered friction, which is a maximum
/// of many readings (design choice).
const DOUBT: f64 = 2.2;
/// Share of the element scatter subtracted from the remembered friction, for the same reason
/// (design choice). At 0.3, objects slip with 5 % crosstalk.
const SCATTER_SHARE: f64 = 0.8;
/// Time constant of the utilisation, s (design choice: rejects single readings).
const FILTER_S: f64 = 0.1;
const FORCE_FILTER_S: f64 = 0.03;
/// Time without disturbance before opening, s (design choice: longer than two windows of dF_t).
const SETTLE_S: f64 = 0.1;
/// Utilisation limit of grip minimisation (design choice).
const TRY_BELOW: f64 = 0.96;
/// Torsion ratio that ends opening in grip minimisation (design choice: below the threshold of
/// Module 2; at 0.42 objects have turned by 12°).
const TRY_TORSION: f64 = 0.35;
/// Torsion ratio below which opening starts (design choice: hysteresis against hand vibration).
const BEGIN_TORSION: f64 = 0.33;
/// Utilisation margin and filtered excess force above which opening starts (design choice:
/// hysteresis).
const BEGIN_SPARE: f64 = 0.025;
const BEGIN_ABOVE: f64 = 0.05;
/// Time after opening in which closing is attributed to it, s (design choice).
const BLAME_S: f64 = 0.5;
/// Momentary utilisation above which the shear is too uniform to open (design choice).
const ALIKE_BELOW: f64 = 0.9;
/// Margin factor on the force-to-load ratio at the last slip (design choice).
const REMEMBERED_MARGIN: f64 = 1.04;
/// Time constant of the element scatter, s (design choice: most of the closing during a lift).
const SCATTER_S: f64 = 0.3;
/// Load below which no object is suspended, N (design choice: noise of two fingertips).
const LOAD_FLOOR_N: f64 = 0.03;

#[derive(Clone, Copy, Debug, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Relax {
    /// Low-passed largest utilisation of the sides; `None` while unknown.
    utilisation: Option<f64>,
    /// Low-passed excess force of the weakest side, as a share.
    above: f64,
    /// Low-passed largest torsion ratio of the sides.
    torsion: f64,
    /// Time without disturbance, s.
    steady_s: f64,
    active: bool,
    /// Remaining attribution time, s.
    blame_s: f64,
    pressing: bool,
    /// Largest force-to-load ratio at which closing restarted on a suspended object: it slipped
    /// there, regardless of the friction reading.
    slipped_at: f64,
    /// Gentlest verified force-to-load ratio, and whether a minimisation awaits verification.
    proved_at: f64,
    tries: bool,
    /// Low-passed element scatter before the first opening; opening unloads the rim of the patch
    /// and adds scatter.
    scatter: f64,
    opened: bool,
}

impl Module for Relax {
    const ID: ModuleId = ModuleId::RELAX;

    fn evaluate(&mut self, percept: &Percept, context: &Context<'_>) -> Proposal {
        let (weakest_n, _) = force_range_n(percept);
        let weakest_n = weakest_n / context.overread;
        let load_n = load_n(percept);
        self.remember(weakest_n, load_n, context);
        self.settle(percept, context);
        self.prove(weakest_n, load_n, context);
        let above = self.above_least(weakest_n, load_n, context);
        let spare = self.spare(percept, context);
        let may = self.steady_s >= SETTLE_S && spare > 0.0 && above > 0.0;
        let turns = self.turns(percept) && context.tries;
        if !self.opened {
            self.listen(percept);
        }
        let begins = spare > BEGIN_SPARE && above > BEGIN_ABOVE;
        self.active = may && !turns && (self.active || begins);
        self.opened |= self.active;
        let opening_m_s = if self.active {
            context.settings.grasp.relax_m_s * (spare.min(above) / SPARE_FULL).min(1.0)
        } else {
            0.0
        };
        Proposal {
            active: self.active,
            closing_m_s: [-opening_m_s; VIRTUAL_FINGERS],
            ..Proposal::default()
        }
    }
}

impl Relax {
    fn prove(&mut self, weakest_n: f64, load_n: f64, context: &Context<'_>) {
        self.tries |= context.tries;
        if context.hangs && self.tries && load_n > LOAD_FLOOR_N {
            (self.proved_at, self.tries) = (weakest_n / load_n, false);
        }
    }

    /// Stores the force-to-load ratio when closing starts on a suspended object.
    fn remember(&mut self, weakest_n: f64, load_n: f64, context: &Context<'_>) {
        let pressing = context.closing_m_s.iter().any(|closing| *closing > 0.0);
        let begins = pressing && !self.pressing;
        self.pressing = pressing;
        self.blame_s = if self.active {
            BLAME_S
        } else {
            self.blame_s - context.step_s
        };
        if begins && self.blame_s > 0.0 && load_n > LOAD_FLOOR_N {
            let ratio = weakest_n / load_n;
            self.slipped_at = self.slipped_at.max(ratio);
        }
    }

    /// Updates the time without load change, slip or closing.
    fn settle(&mut self, percept: &Percept, context: &Context<'_>) {
        let dr_n = context.settings.grasp.dr_n;
        let calm = |finger: &FingerPercept| {
            let steady_n = dr_n.max(STEADY_SHARE * finger.tangential_n);
            finger.increment_n < steady_n
                && finger.gross_slip_s == 0.0
                && (context.tries || finger.utilisation_now < ALIKE_BELOW)
        };
        let steady = (context.hangs || context.tries)
            && !self.pressing
            && percept.virtual_fingers.iter().all(calm);
        self.steady_s = if steady {
            self.steady_s + context.step_s
        } else {
            0.0
        };
    }

    /// Returns the low-passed share of the force above the minimum known without friction.
    fn above_least(&mut self, weakest_n: f64, load_n: f64, context: &Context<'_>) -> f64 {
        let remembered_n = (REMEMBERED_MARGIN * self.slipped_at).max(self.proved_at) * load_n;
        let least_n = (LEAST_MARGIN * context.least_n).max(remembered_n);
        let above = if weakest_n > least_n {
            1.0 - least_n / weakest_n
        } else {
            weakest_n / least_n - 1.0
        };
        self.above = low_pass(self.above, above, context.step_s, FORCE_FILTER_S);
        self.above
    }

    /// Returns the margin to the utilisation limit; zero if unknown.
    fn spare(&mut self, percept: &Percept, context: &Context<'_>) -> f64 {
        let below = if context.tries {
            TRY_BELOW
        } else {
            context.settings.grasp.relax_below
        };
        let utilisation = self.watch(percept, context);
        utilisation.map_or(0.0, |utilisation| {
            1.0 - utilisation * context.overread / below
        })
    }

    /// Returns whether further opening would turn the object.
    fn turns(&mut self, percept: &Percept) -> bool {
        let fingers = &percept.virtual_fingers;
        let most = fingers.iter().fold(0.0, |most: f64, f| most.max(f.torsion));
        self.torsion = low_pass(self.torsion, most, percept.step_s, FILTER_S);
        let limit = if self.active {
            TRY_TORSION
        } else {
            BEGIN_TORSION
        };
        self.torsion > limit
    }

    fn listen(&mut self, percept: &Percept) {
        let fingers = &percept.virtual_fingers;
        let squares: f64 = fingers.iter().map(|f| f.scatter * f.scatter).sum();
        let now = libm::sqrt(squares / fingers.len() as f64);
        self.scatter = low_pass(self.scatter, now, percept.step_s, SCATTER_S);
    }

    /// Returns the low-passed utilisation, if known for every side.
    fn watch(&mut self, percept: &Percept, context: &Context<'_>) -> Option<f64> {
        let step_s = context.step_s;
        let fingers = &percept.virtual_fingers;
        let scatter = if context.tries { 0.0 } else { self.scatter };
        let known = fingers.iter().all(|f| f.utilisation > 0.0);
        let most = fingers
            .iter()
            .map(|finger| doubtful_utilisation(finger, scatter))
            .fold(0.0, |most, utilisation| {
                if utilisation > most {
                    utilisation
                } else {
                    most
                }
            });
        self.utilisation = known.then(|| {
            let before = self.utilisation.unwrap_or(most);
            low_pass(before, most, step_s, FILTER_S)
        });
        self.utilisation
    }
}

/// Returns the utilisation with the friction reduced by its possible error. Shear and rotation
/// combine on an elliptic limit surface (R. D. Howe and M. R. Cutkosky, 1996).
fn doubtful_utilisation(finger: &FingerPercept, scatter: f64) -> f64 {
    let friction = finger.friction.max(FRICTION_FLOOR);
    let least =
        (friction - DOUBT * finger.friction_error - SCATTER_SHARE * scatter).max(FRICTION_FLOOR);
    libm::hypot(finger.utilisation, finger.torsion) * friction / least
}
