//! Grip relaxation (not in the paper): reduces force that friction does not need.
//!
//! The paper's grasp ends with a "suitable normal force that generated maximum static friction
//! force", but modules 1 to 3 only add force. The fingers open slowly while the object is
//! suspended, its load is steady (dF_t < dr) and every side's utilisation is below `relax_below`.
//! The force stays above the minimum grip force, and above the force-to-load ratio at which opening
//! last caused closing. The fingers never open wider than at the lift verification: if the force
//! seems to grow there, the zero of a sensor drifts.
//!
//! A poor sensor may misread friction by more than the grip's margin. In grip minimisation, the
//! fingers therefore open down to `MINIMISE_UTILISATION`. The verified force is then the minimum.

use super::slip::STEADY_SHARE;
use super::{Context, Module, Proposal};
use crate::filter::{Dwell, low_pass};
use crate::limits::FRICTION_FLOOR;
use crate::perception::{ContactPercept, Percept};
use robot_model::PerSide;
use shm_schemas::ModuleId;

/// Factor above the minimum force at which opening stops (design choice: keeps Module 1 inactive).
const MIN_FORCE_MARGIN: f64 = 1.1;
/// Utilisation margin above which opening runs at full speed (design choice).
const FULL_SPEED_MARGIN: f64 = 0.1;
/// Standard deviations of sensor noise subtracted from the remembered friction, which is a maximum
/// of many readings (design choice).
const FRICTION_ERROR_MARGIN: f64 = 2.2;
/// Share of the element scatter subtracted from the remembered friction, for the same reason
/// (design choice). At 0.3, objects slip with 5 % crosstalk.
const SCATTER_SHARE: f64 = 0.8;
/// Time constant of the utilisation, s (design choice: rejects single readings).
const FILTER_S: f64 = 0.1;
const FORCE_FILTER_S: f64 = 0.03;
/// Time without disturbance before opening, s (design choice: longer than two windows of dF_t).
const STEADY_MIN_S: f64 = 0.1;
/// Utilisation limit of grip minimisation (design choice).
const MINIMISE_UTILISATION: f64 = 0.96;
/// Torsion ratio that ends opening in grip minimisation (design choice: below the threshold of
/// Module 2; at 0.42 objects have turned by 12°).
const MINIMISE_TORSION: f64 = 0.35;
/// Torsion ratio below which opening starts (design choice: hysteresis against hand vibration).
const START_TORSION: f64 = 0.33;
/// Utilisation margin and filtered excess force above which opening starts (design choice:
/// hysteresis).
const START_MARGIN: f64 = 0.025;
const START_EXCESS: f64 = 0.05;
/// Time after opening in which closing is attributed to it, s (design choice).
const OPENING_EFFECT_S: f64 = 0.5;
/// Momentary utilisation above which the shear is too uniform to open (design choice).
const UNIFORM_SHEAR_BELOW: f64 = 0.9;
/// Margin factor on the force-to-load ratio at the last slip. Design choice: kinetic friction is a
/// tenth lower than static friction, and the load trembles by a few per cent. At 1.04, an object
/// that slips once may slide on slowly, without a change of the load.
const SLIP_RATIO_MARGIN: f64 = 1.15;
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
    excess: f64,
    /// Low-passed largest torsion ratio of the sides.
    torsion: f64,
    /// Time without disturbance.
    steady: Dwell,
    active: bool,
    /// Remaining attribution time, s.
    opening_effect_s: f64,
    pressing: bool,
    /// Largest force-to-load ratio at which closing restarted on a suspended object: it slipped
    /// there, regardless of the friction reading.
    slip_ratio: f64,
    /// Gentlest verified force-to-load ratio, and whether a minimisation awaits verification.
    verified_ratio: f64,
    minimised: bool,
    /// Low-passed element scatter before the first opening; opening unloads the rim of the patch
    /// and adds scatter.
    scatter: f64,
    opened: bool,
}

impl Module for Relax {
    const ID: ModuleId = ModuleId::RELAX;

    fn evaluate(&mut self, percept: &Percept, context: &Context<'_>) -> Proposal {
        let (weakest_n, _) = percept.normal_range_n();
        let weakest_n = weakest_n / context.hand.tactile_over_torque;
        let load_n = percept.total_tangential_n();
        self.update_slip_ratio(weakest_n, load_n, context);
        self.update_steady_time(percept, context);
        self.update_verified_ratio(weakest_n, load_n, context);
        let above = self.excess_force(weakest_n, load_n, context);
        let spare = self.utilisation_margin(percept, context);
        let is_closed = context.object.grip.is_none_or(|grip| grip.closed_m > 0.0);
        let may = self.steady.seconds() >= STEADY_MIN_S && spare > 0.0 && above > 0.0 && is_closed;
        let turns = self.exceeds_torsion(percept) && context.object.minimises_grip;
        if !self.opened {
            self.update_scatter(percept);
        }
        let begins = spare > START_MARGIN && above > START_EXCESS;
        self.active = may && !turns && (self.active || begins);
        self.opened |= self.active;
        let opening_m_s = if self.active {
            context.settings.grasp.relax_m_s * (spare.min(above) / FULL_SPEED_MARGIN).min(1.0)
        } else {
            0.0
        };
        Proposal {
            active: self.active,
            closing_m_s: PerSide::repeat(-opening_m_s),
            ..Proposal::default()
        }
    }
}

impl Relax {
    fn update_verified_ratio(&mut self, weakest_n: f64, load_n: f64, context: &Context<'_>) {
        self.minimised |= context.object.minimises_grip;
        if context.object.suspended && self.minimised && load_n > LOAD_FLOOR_N {
            (self.verified_ratio, self.minimised) = (weakest_n / load_n, false);
        }
    }

    /// Stores the force-to-load ratio when closing starts on a suspended object.
    fn update_slip_ratio(&mut self, weakest_n: f64, load_n: f64, context: &Context<'_>) {
        let pressing = context
            .hand
            .closing_m_s
            .iter()
            .any(|closing| *closing > 0.0);
        let begins = pressing && !self.pressing;
        self.pressing = pressing;
        self.opening_effect_s = if self.active {
            OPENING_EFFECT_S
        } else {
            self.opening_effect_s - context.step_s
        };
        if begins && self.opening_effect_s > 0.0 && load_n > LOAD_FLOOR_N {
            let ratio = weakest_n / load_n;
            self.slip_ratio = self.slip_ratio.max(ratio);
        }
    }

    /// Updates the time without load change, slip or closing.
    fn update_steady_time(&mut self, percept: &Percept, context: &Context<'_>) {
        let dr_n = context.settings.grasp.dr_n;
        let calm = |finger: &ContactPercept| {
            let steady_n = dr_n.max(STEADY_SHARE * finger.tangential_n);
            finger.increment_n < steady_n
                && finger.gross_slip_s == 0.0
                && (context.object.minimises_grip || finger.utilisation_now < UNIFORM_SHEAR_BELOW)
        };
        let steady = (context.object.suspended || context.object.minimises_grip)
            && !self.pressing
            && percept.sides.iter().all(calm);
        self.steady.update(steady, context.step_s);
    }

    /// Returns the low-passed share of the force above the minimum known without friction.
    fn excess_force(&mut self, weakest_n: f64, load_n: f64, context: &Context<'_>) -> f64 {
        let remembered_n = (SLIP_RATIO_MARGIN * self.slip_ratio).max(self.verified_ratio) * load_n;
        let least_n = (MIN_FORCE_MARGIN * context.object.min_force_n).max(remembered_n);
        let above = if weakest_n > least_n {
            1.0 - least_n / weakest_n
        } else {
            weakest_n / least_n - 1.0
        };
        self.excess = low_pass(self.excess, above, context.step_s, FORCE_FILTER_S);
        self.excess
    }

    /// Returns the margin to the utilisation limit; zero if unknown.
    fn utilisation_margin(&mut self, percept: &Percept, context: &Context<'_>) -> f64 {
        let below = if context.object.minimises_grip {
            MINIMISE_UTILISATION
        } else {
            context.settings.grasp.relax_below
        };
        let utilisation = self.update_utilisation(percept, context);
        utilisation.map_or(0.0, |utilisation| {
            1.0 - utilisation * context.hand.tactile_over_torque / below
        })
    }

    /// Returns whether further opening would turn the object.
    fn exceeds_torsion(&mut self, percept: &Percept) -> bool {
        let sides = &percept.sides;
        let most = sides
            .iter()
            .fold(0.0, |most: f64, side| most.max(side.torsion));
        self.torsion = low_pass(self.torsion, most, percept.step_s, FILTER_S);
        let limit = if self.active {
            MINIMISE_TORSION
        } else {
            START_TORSION
        };
        self.torsion > limit
    }

    fn update_scatter(&mut self, percept: &Percept) {
        let sides = &percept.sides;
        let squares = sides.each_ref().map(|side| side.scatter * side.scatter);
        let now = libm::sqrt(squares.mean());
        self.scatter = low_pass(self.scatter, now, percept.step_s, SCATTER_S);
    }

    /// Returns the low-passed utilisation, if known for every side.
    fn update_utilisation(&mut self, percept: &Percept, context: &Context<'_>) -> Option<f64> {
        let step_s = context.step_s;
        let sides = &percept.sides;
        let scatter = if context.object.minimises_grip {
            0.0
        } else {
            self.scatter
        };
        let known = sides.iter().all(|side| side.utilisation > 0.0);
        let most = sides
            .iter()
            .map(|side| pessimistic_utilisation(side, scatter))
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
fn pessimistic_utilisation(finger: &ContactPercept, scatter: f64) -> f64 {
    let friction = finger.friction.max(FRICTION_FLOOR);
    let least =
        (friction - FRICTION_ERROR_MARGIN * finger.friction_error - SCATTER_SHARE * scatter)
            .max(FRICTION_FLOOR);
    libm::hypot(finger.utilisation, finger.torsion) * friction / least
}
