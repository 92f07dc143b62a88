//! Relax (ours, not in the paper): lets go of force that friction does not need.
//!
//! The paper's grasp ends with a "suitable normal force that generated maximum static friction force"; modules 1 to 3
//! alone can only ever add force. While the object hangs, its load is steady (dF_t < dr) and every finger uses less than
//! `relax_below` of its friction, the fingers open slowly, the more slowly the nearer they are to it, and never below the
//! least force of a grip, nor below the force, for the present load, at which opening made it necessary to press again.
//!
//! What a poor sensor says of friction may be wrong by more than a grip has to spare. So while the load test tries how gently
//! what hangs just above its support can be held, the fingers open further, down to `TRY_BELOW`; the force that the test has
//! proved is then the least.

use super::slip::STEADY_SHARE;
use super::{Context, Module, Proposal, force_range_n, load_n};
use crate::filter::low_pass;
use crate::limits::FRICTION_FLOOR;
use crate::perception::{FingerPercept, Percept};
use robot_model::VIRTUAL_FINGERS;
use shm_schemas::ModuleId;

/// Multiple of the least force down to which the module relaxes: a little above, so that Module 1 need not answer (ours).
const LEAST_MARGIN: f64 = 1.1;
/// Spare utilisation from which on it opens at full speed (ours: a tenth of the friction is a tenth of the force).
const SPARE_FULL: f64 = 0.1;
/// How many standard deviations noise may have added to the remembered friction (ours): it is the highest of many
/// readings, each of the elements that read highest.
const DOUBT: f64 = 2.2;
/// Share of the elements' disagreement that may have been added to the remembered friction (ours): it is read from those
/// that report most. At 0.3 objects slip out of a skin with 5 % crosstalk.
const SCATTER_SHARE: f64 = 0.8;
/// Time constant over which the utilisation is judged, s (ours: it only ever opens, so it must not follow single readings).
const FILTER_S: f64 = 0.1;
const FORCE_FILTER_S: f64 = 0.03;
/// How long everything must have been steady before it opens, s (ours: two windows of dF_t are not).
const SETTLE_S: f64 = 0.1;
/// Utilisation down to which a grip is relaxed where a slip costs nothing and a test follows (ours).
const TRY_BELOW: f64 = 0.96;
/// Share of the moment that friction could carry beyond which it is not (ours: below where Module 2 answers; at 0.42 objects
/// have turned by 12°).
const TRY_TORSION: f64 = 0.35;
/// Share of it below which it begins to open (ours): like the two that follow, less by more than a trembling hand changes it, so
/// that what has ended does not begin again.
const BEGIN_TORSION: f64 = 0.33;
/// Spare utilisation, and low-passed share of the force that is more than the least, above which it begins to open (ours).
const BEGIN_SPARE: f64 = 0.025;
const BEGIN_ABOVE: f64 = 0.05;
/// How long after it opened pressing is blamed on it, s (ours).
const BLAME_S: f64 = 0.5;
/// Momentary utilisation above which a patch is sheared so much alike that it does not open (ours).
const ALIKE_BELOW: f64 = 0.9;
/// Multiple of the force, for the load of then, at which pressing was last necessary: never below (ours).
const REMEMBERED_MARGIN: f64 = 1.04;
/// Time constant over which the disagreement of elements is felt, s (ours: most of a lift's pressing).
const SCATTER_S: f64 = 0.3;
/// Load below which nothing hangs, N (ours: the noise of two fingertips).
const LOAD_FLOOR_N: f64 = 0.03;

/// What the module remembers.
#[derive(Clone, Copy, Debug, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Relax {
    /// Low-passed utilisation of the finger that uses most of its friction; `None` while it is unknown.
    utilisation: Option<f64>,
    /// Low-passed share of the weakest finger's force that is more than the least.
    above: f64,
    /// Low-passed share of the moment of the finger that carries most of its own.
    torsion: f64,
    /// How long everything has been steady, s.
    steady_s: f64,
    /// Whether it opened in the tick before.
    active: bool,
    /// Time for which pressing is still blamed on its opening, s.
    blame_s: f64,
    /// Whether the fingers closed in the tick before.
    pressing: bool,
    /// Largest force over load at which they began to, while the object hung: there it slipped, whatever a poor sensor says of
    /// its friction.
    slipped_at: f64,
    /// Force over load of the gentlest grip that a test has proved, and whether one is being tried.
    proved_at: f64,
    tries: bool,
    /// How far elements disagree, low-passed, as it was before it opened: what lets go of a patch at its rim makes them
    /// disagree as well.
    scatter: f64,
    /// Whether it has ever opened.
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
    /// Notes the force, for its load, that a test has just proved.
    fn prove(&mut self, weakest_n: f64, load_n: f64, context: &Context<'_>) {
        self.tries |= context.tries;
        if context.hangs && self.tries && load_n > LOAD_FLOOR_N {
            (self.proved_at, self.tries) = (weakest_n / load_n, false);
        }
    }

    /// Notes the force, for its load, at which the fingers begin to press although the object hangs.
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

    /// Counts how long the load has not changed, nothing has slid and nobody has pressed.
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

    /// Share of the force that is more than a grip needs at least, for all that is known without friction; low-passed as well.
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

    /// Share of the utilisation that may still be used up; nothing while it is unknown.
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

    /// Whether a patch carries so much of the moment that friction could that what is tried would turn.
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

    /// Low-passes what the elements disagree about.
    fn listen(&mut self, percept: &Percept) {
        let fingers = &percept.virtual_fingers;
        let squares: f64 = fingers.iter().map(|f| f.scatter * f.scatter).sum();
        let now = libm::sqrt(squares / fingers.len() as f64);
        self.scatter = low_pass(self.scatter, now, percept.step_s, SCATTER_S);
    }

    /// The low-passed utilisation, while every finger knows its own.
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

/// Utilisation if the friction is as much less than remembered as noise may have added to it. A patch that is sheared and
/// turned at once has the friction of an ellipse of both (limit surface of R. D. Howe and M. R. Cutkosky, 1996).
fn doubtful_utilisation(finger: &FingerPercept, scatter: f64) -> f64 {
    let friction = finger.friction.max(FRICTION_FLOOR);
    let least =
        (friction - DOUBT * finger.friction_error - SCATTER_SHARE * scatter).max(FRICTION_FLOOR);
    libm::hypot(finger.utilisation, finger.torsion) * friction / least
}
