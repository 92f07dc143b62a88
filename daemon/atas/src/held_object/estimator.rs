//! Estimator of the held object: updates all estimates once per tick.

use super::contact::Contact;
use super::drift::Drift;
use super::drop_detector::DropDetector;
use super::estimate::{HeldObject, LiftFinding, StepFacts};
use super::lever::Lever;
use super::load_response::LoadResponse;
use super::verified_grip::GripVerification;
use super::weight::Weight;
use crate::executor::HandMotion;
use crate::filter::Dwell;
use crate::perception::{Percept, StiffnessFit};
use crate::settings::Settings;
use crate::thresholds::Thresholds;
use nalgebra::Vector3;
use robot_model::GraspPose;

/// Carried distance above which only the hand holds the object, m (design choice).
const SUSPENDED_MIN_M: f64 = 0.001;
/// Swing time of a load after a change of speed, s (design choice).
const SWING_S: f64 = 0.15;

/// Share of F_2 with which a hand steadies an object for the other hand (design choice: the work
/// loads the grip suddenly, and a slide cannot be undone).
const STEADY_SHARE: f64 = 0.4;

/// Estimator of the held object of one hand.
#[derive(Clone, Copy, Debug)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct HeldObjectEstimator {
    pub(super) object: HeldObject,
    pub(super) stiffness: Option<StiffnessFit>,
    /// The fingers have gripped it, and nothing has opened them since.
    pub(super) is_gripped: bool,
    /// It was found in the hand: its origin is unknown.
    pub(super) is_found: bool,
    pub(super) contact: Contact,
    pub(super) no_contact: Dwell,
    /// Lift verification has succeeded.
    pub(super) is_verified: bool,
    /// Speed factor of the hand in the previous tick, and remaining swing time, s.
    carry_scale: f64,
    swing_s: f64,
    pub(super) verification: GripVerification,
    response: LoadResponse,
    drop_detector: DropDetector,
    /// Duration of a drop of a verified object, and of a drift.
    pub(super) dropping: Dwell,
    pub(super) drifting: Dwell,
    pub(super) weight: Weight,
    pub(super) lever: Lever,
}

impl HeldObjectEstimator {
    /// Creates the estimator of an object that is not yet touched.
    #[must_use]
    pub fn new(thresholds: Thresholds) -> Self {
        Self {
            object: HeldObject::untouched(thresholds),
            stiffness: None,
            is_gripped: false,
            is_found: false,
            contact: Contact::default(),
            no_contact: Dwell::default(),
            is_verified: false,
            carry_scale: 0.0,
            swing_s: 0.0,
            verification: GripVerification::default(),
            response: LoadResponse::default(),
            drop_detector: DropDetector::default(),
            dropping: Dwell::default(),
            drifting: Dwell::default(),
            weight: Weight::default(),
            lever: Lever::default(),
        }
    }

    /// Creates the estimator of an object that the hand already holds at `centre_m`, base frame.
    #[must_use]
    pub fn for_found_object(thresholds: Thresholds, centre_m: Vector3<f64>) -> Self {
        Self {
            is_gripped: true,
            is_found: true,
            contact: Contact::found(centre_m),
            verification: GripVerification::for_found_grip(),
            ..Self::new(thresholds)
        }
    }

    /// Begins another search: forgets the contact, but neither thresholds nor stiffness.
    pub fn begin_search(&mut self) {
        *self = Self {
            stiffness: self.stiffness,
            is_gripped: self.is_gripped,
            is_found: self.is_found,
            no_contact: self.no_contact,
            ..Self::new(self.object.thresholds)
        };
    }

    /// Updates the estimate from one tick: percept, motion of the hand, measured distance of the
    /// fingertips, m, duration of the tick, s, and properties of the step.
    pub fn update(
        &mut self,
        percept: &Percept,
        hand: &HandMotion<'_>,
        (gap_m, step_s): (f64, f64),
        step: StepFacts,
        settings: &Settings,
    ) {
        let touches = percept.sides.iter().all(|side| side.in_contact);
        self.no_contact.update(!touches, step_s);
        if step.searches && touches {
            self.contact.touch(gap_m);
        }
        let net_n = percept.net_force_n(hand.base_from_tip);
        self.update_swing(hand.carry_scale, step_s);
        self.update_support(hand.pose, gap_m, step, settings);
        self.update_grip(percept, &net_n, hand, step.lowers, settings);
        self.update_drop(percept);
        if step.is_monitored && self.is_carried() && !self.is_found {
            self.update_in_hand(percept);
        }
    }

    fn update_support(
        &mut self,
        now: &GraspPose,
        gap_m: f64,
        step: StepFacts,
        settings: &Settings,
    ) {
        let Thresholds { f1_n, f2_n, .. } = self.object.thresholds;
        let min_force_n = if step.steadies {
            f1_n.max(STEADY_SHARE * f2_n)
        } else if self.is_carried() && settings.grasp.carry_min_n < f1_n {
            settings.grasp.carry_min_n
        } else {
            f1_n
        };
        let suspended = self.is_verified || !step.verifies_lift;
        let carried_m = self.contact.carried_m(now);
        let carried_freely = suspended && carried_m > SUSPENDED_MIN_M && !step.lowers;
        self.object = HeldObject {
            min_force_n,
            all_touched: self.contact.all_touched(),
            closing_m: self.contact.closing_m(gap_m),
            carried_m,
            suspended,
            carried_freely,
            swings: (carried_freely || self.object.minimises_grip) && self.swing_s > 0.0,
            ..self.object
        };
    }

    fn update_swing(&mut self, carry_scale: f64, step_s: f64) {
        self.swing_s = if self.carry_scale == carry_scale {
            self.swing_s - step_s
        } else {
            SWING_S
        };
        self.carry_scale = carry_scale;
    }

    /// Updates the load, the load that the grip holds, and the drift of the tactile zero.
    fn update_grip(
        &mut self,
        percept: &Percept,
        net_n: &Vector3<f64>,
        hand: &HandMotion<'_>,
        lowers: bool,
        settings: &Settings,
    ) {
        let object = &mut self.object;
        object.down_n = -net_n.z;
        let across_n = across_axis_n(net_n, &hand.closing_axis);
        let opening_m = hand.pose.half_opening_m.iter().sum();
        let load = (across_n, object.drift.reported_n());
        object.grip = self.verification.update(percept, load, opening_m);
        let lifts = object.carried_m > 0.0 && !object.suspended;
        let forces_n = (percept.total_normal_n(), object.down_n);
        let without_response = self
            .response
            .is_unresponsive(lifts.then_some(forces_n), percept.step_s);
        object.load_is_held = self.verification.is_held() || without_response;
        let object_m_n = settings.grasp.compression_m / object.thresholds.f2_n;
        object.drift = object.grip.map_or(Drift::default(), |grip| {
            Drift::estimate(&grip, &hand.compression, object_m_n, lowers)
        });
        let drifts = self.is_gripped && object.drift.is_reported;
        self.drifting.update(drifts, percept.step_s);
    }

    fn update_drop(&mut self, percept: &Percept) {
        let object = &mut self.object;
        let hangs = object.carried_freely || object.minimises_grip;
        let load_n = hangs.then_some(object.down_n);
        object.drops = self
            .drop_detector
            .update(load_n, object.swings, percept.step_s);
        self.dropping
            .update(object.drops && self.is_verified, percept.step_s);
    }

    fn update_in_hand(&mut self, percept: &Percept) {
        if self.object.carried_m <= 0.0 || percept.step_s <= 0.0 {
            return;
        }
        let HeldObject { down_n, drops, .. } = self.object;
        self.lever.update(percept, down_n);
        if self.is_verified {
            self.weight.update(down_n, drops, percept.step_s);
        }
    }

    /// Receives the result of lift verification; `is_monitored` as in [`StepFacts`].
    pub fn receive(&mut self, finding: LiftFinding, is_monitored: bool) {
        let minimised = self.object.minimises_grip && finding == LiftFinding::None;
        self.object.minimises_grip = finding == LiftFinding::MinimisesGrip;
        match finding {
            LiftFinding::Suspended if !self.is_verified => {
                self.verification.set_verified();
                self.is_verified = true;
            }
            LiftFinding::Standing => {
                self.verification.forget();
                if is_monitored && self.is_carried() && !self.is_found {
                    self.weight.stands(self.object.carried_m);
                }
            }
            LiftFinding::None if minimised => self.verification.set_held(),
            _ => {}
        }
    }

    /// Sets stiffness and thresholds after the probe: the fingers grip the object.
    pub fn set_stiffness(&mut self, fit: StiffnessFit, thresholds: Thresholds) {
        self.stiffness = Some(fit);
        self.is_gripped = true;
        self.object.thresholds = thresholds;
    }

    /// Forgets stiffness and thresholds, for another probe.
    pub fn reset_probe(&mut self, thresholds: Thresholds) {
        (self.stiffness, self.object.thresholds) = (None, thresholds);
    }

    /// Begins to lift a gripped object from `centre_m`, base frame.
    pub fn lift(&mut self, centre_m: Vector3<f64>) {
        self.contact.lift(centre_m);
    }

    /// The fingers open, or the cap on its neck turns with them: the hand holds nothing by itself.
    pub fn let_go(&mut self) {
        self.is_gripped = false;
    }

    /// Restarts the estimates of slip, rotation and loss, because other motion resembles them.
    pub fn restart_in_hand(&mut self) {
        (self.weight, self.lever) = (Weight::default(), Lever::default());
    }

    /// Keeps an object without load only while it touches every side: something else may carry it.
    pub fn keep_if_touched(&mut self) {
        self.is_gripped &= !self.has_lost_contact();
        self.restart_in_hand();
    }
}

/// Returns the part of a net force across the closing axis, N. Friction carries it.
fn across_axis_n(net_n: &Vector3<f64>, closing_axis: &Vector3<f64>) -> f64 {
    let across_n = net_n - closing_axis * net_n.dot(closing_axis);
    libm::sqrt(across_n.norm_squared())
}
