//! Regrasp: corrects the grasp from the measured object pose.
//!
//! * Object off-centre or rotated at the source: opens and regrasps at the measured place.
//! * Lift failed or object rotated, weight off-centre: puts back, opens, regrasps nearer to the
//!   centre of mass.
//! * Object too soft for its weight and rotated while probed: puts back, opens, regrasps and probes
//!   again.
//!
//! Each correction happens once. Displacements beyond plausible goal errors are ignored. No shift
//! exceeds the clearance margin of the goal check.

use super::Runner;
use super::in_hand::InHand;
use crate::limits::{DISPLACED_MAX_M, TURNED_MAX_RAD};
use crate::modules::{Modules, Verdict};
use crate::perception::{ObjectPose, Percept};
use crate::settings::Settings;
use crate::tasks::{COME_AGAIN, Motion, Step, Transition, Waypoint};
use core::f64::consts::FRAC_PI_2;
use nalgebra::Vector2;
use robot_model::GraspFrame;
use shm_schemas::Cause;

/// Radius of the hand bodies about their rotation axis, m (design choice: palms of the built-in
/// robots).
const REACH_M: f64 = 0.06;
/// Off-centre distance that triggers a regrasp when two hands join objects, m (design choice: half
/// the capture range of a neck). The clearance check relies on the object place.
const JOIN_M: f64 = 0.001;
/// Ratio of lateral shift to measured lever (design choice, measured): rotation in the hand
/// shortens the measured lever.
const LEVER_GAIN: f64 = 1.5;
/// Lever beyond which a suspended object is put back, m (design choice: exceeds a place error of 2
/// mm). Otherwise it needs several times the force and rotates at the first shake.
const HANGS_ASKEW_M: f64 = 0.0022;
/// Maximum lift height for putting back, m (design choice, measured): objects that rotate higher up
/// may topple on release.
const PUT_BACK_MAX_M: f64 = 0.016;
/// Maximum lateral shift for a lever, m (design choice).
const ASIDE_MAX_M: f64 = 0.006;
/// Maximum offset across the closing axis of a flat object, m (design choice; measured: below 0.1
/// mm for flat faces). Round objects are graspable only about their axis.
const ROUND_M: f64 = 0.0003;
/// Indices in [`COME_AGAIN`]: start with a lifted object, or with a standing one.
const PUT_BACK: usize = 0;
const REOPEN: usize = 1;

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Regrasp {
    /// Step to resume after the regrasp; `None` if no regrasp is active.
    before: Option<usize>,
    /// The hand regrasped at the measured place.
    placed: bool,
    /// The hand regrasped nearer to the centre of mass.
    balanced: bool,
    /// The hand regrasped to probe again.
    probed: bool,
}

impl Runner {
    /// Steps in force: those of the task or of a regrasp.
    pub(super) fn steps(&self) -> &[Step] {
        match self.regrasp.before {
            Some(_) => &COME_AGAIN,
            None => &self.track,
        }
    }

    /// Displacement of the object from its commanded place, base frame, m; zero while unknown.
    #[must_use]
    pub fn displaced_m(&self) -> Vector2<f64> {
        self.displaced_m
    }

    /// Starts, continues or ends a regrasp at the end of a step. Returns true if it entered another
    /// step.
    pub(super) fn regrasps(
        &mut self,
        now: &GraspFrame,
        settings: &Settings,
        modules: &mut Modules,
    ) -> bool {
        if let Some(index) = self.regrasp.before {
            if self.index == PUT_BACK {
                self.reopen(now, settings, modules);
                return true;
            }
            let is_back = self.index + 1 == COME_AGAIN.len();
            if is_back {
                self.regrasp.before = None;
                self.enter(index, now, settings, modules);
            }
            return is_back;
        }
        if self.step().transition != Transition::Gripped {
            return false;
        }
        let Some(index) = self.search() else {
            return false;
        };
        let comes_again = self.learn_place(now, settings);
        if comes_again {
            self.regrasp.before = Some(index);
            self.reopen(now, settings, modules);
        }
        comes_again
    }

    /// Releases the standing object and resets its thresholds and stiffness.
    fn reopen(&mut self, now: &GraspFrame, settings: &Settings, modules: &mut Modules) {
        modules.let_go();
        self.thresholds = self.wishes.thresholds_before_touch(settings);
        self.stiffness = None;
        self.enter(REOPEN, now, settings, modules);
    }

    /// Returns true if the lift is rejected or out of force, or the object rotates or has too long
    /// a lever.
    fn lifts_badly(&self, verdict: Verdict, percept: &Percept) -> bool {
        let is_refused =
            matches!(verdict, Verdict::Refuse(reason) if reason.cause != Cause::OBSTRUCTED);
        let hangs_askew = self.tries && self.in_hand.lever_m().abs() > HANGS_ASKEW_M;
        is_refused || hangs_askew || self.turns().is_some() || self.out_of_force(percept).is_some()
    }

    /// Puts back an object that cannot be lifted, for a shifted grasp or another probe. Returns
    /// true if it did.
    pub(super) fn grasps_anew(
        &mut self,
        verdict: Verdict,
        percept: &Percept,
        now: &GraspFrame,
        settings: &Settings,
        modules: &mut Modules,
    ) -> bool {
        let lifts = self.step().motion == Motion::Carry(Waypoint::Lifted);
        let is_low = self.carried_m < PUT_BACK_MAX_M;
        if !(lifts && is_low) || self.found || self.waypoints.joins() {
            return false;
        }
        if !self.lifts_badly(verdict, percept) {
            return false;
        }
        let Some(index) = self.search() else {
            return false;
        };
        let regrasp = Regrasp {
            before: Some(index),
            ..self.regrasp
        };
        let aside = self.aside(settings);
        if aside.is_some() {
            // If the object proves to be round, the hand returns to its centre.
            self.regrasp = Regrasp {
                placed: false,
                balanced: true,
                ..regrasp
            };
        } else if self.is_to_be_probed_again(verdict) {
            self.regrasp = Regrasp {
                probed: true,
                ..regrasp
            };
        } else {
            return false;
        }
        // Motion on the way back counts neither as slip nor as rotation.
        (self.holds, self.in_hand) = (false, InHand::default());
        self.enter(PUT_BACK, now, settings, modules);
        if let Some((aside_m, axis)) = aside {
            self.waypoints.grasp_aside(aside_m, &axis);
        }
        true
    }

    /// Returns the lateral shift towards the centre of mass, m, and the closing axis; once per
    /// task.
    fn aside(&self, settings: &Settings) -> Option<(f64, Vector2<f64>)> {
        let felt = self.felt.filter(|_| !self.regrasp.balanced)?;
        let across_m = felt.closing_axis.perp(&felt.off_m);
        let lever_m = self.in_hand.lever_m();
        let aside_m = (lever_m * LEVER_GAIN).clamp(-ASIDE_MAX_M, ASIDE_MAX_M);
        let has_room = self.displaced_m.norm() + aside_m.abs() <= self.waypoints.spare_m();
        // False for NaN.
        let is_flat = across_m.abs() < ROUND_M;
        let goes = lever_m.abs() >= settings.grasp.regrasp_lever_m && has_room && is_flat;
        goes.then_some((aside_m, felt.closing_axis))
    }

    /// Returns true once if the object was rejected as too soft but may have rotated against the
    /// fingertips.
    fn is_to_be_probed_again(&self, verdict: Verdict) -> bool {
        let too_soft =
            matches!(verdict, Verdict::Refuse(reason) if reason.cause == Cause::TOO_SOFT);
        let settled = self.stiffness.is_some_and(|fit| fit.settled);
        too_soft && settled && !self.regrasp.probed
    }

    /// Returns the step that searched for the object, if the hand came to the source for it and
    /// went nowhere else since.
    fn search(&self) -> Option<usize> {
        if self.step().is_read_off() || self.retreat.is_some() {
            return None;
        }
        let stays =
            |step: &Step| matches!(step.motion, Motion::Stay | Motion::Carry(Waypoint::Lifted));
        let before = &self.track[..self.index];
        let came = before.iter().rposition(|step| !stays(step))?;
        (before[came].motion == Motion::Reach(Waypoint::Source)).then_some(came + 1)
    }

    /// Updates the displacement of the object and returns true if the hand must regrasp at the
    /// measured place.
    fn learn_place(&mut self, now: &GraspFrame, settings: &Settings) -> bool {
        let Some((felt, off_m)) = self.beside(now) else {
            return false;
        };
        let at_m = now.centre_m.xy() + off_m;
        let displaced_m = at_m - self.waypoints.told_m();
        let turned = felt.turn_rad.abs();
        // False for NaN.
        let believed = displaced_m.norm() < DISPLACED_MAX_M && turned < TURNED_MAX_RAD;
        let has_room = displaced_m.norm() + turned * REACH_M <= self.waypoints.spare_m();
        if !(believed && has_room) {
            return false;
        }
        self.displaced_m = displaced_m;
        let near_m = if self.waypoints.joins() {
            settings.grasp.regrasp_m.min(JOIN_M)
        } else {
            settings.grasp.regrasp_m
        };
        let is_far = off_m.norm() > near_m || turned > settings.grasp.regrasp_rad;
        if !is_far || self.regrasp.placed {
            return false;
        }
        // Only a hand from above can rotate about the object; a side grasp must point at it.
        let turns = now.hand_pitch_rad >= FRAC_PI_2;
        let turn_rad = if turns { felt.turn_rad } else { 0.0 };
        self.waypoints.grasp_at(&at_m, turn_rad);
        self.regrasp.placed = true;
        true
    }

    /// Updates the offset of the held object along the closing axis for placing. Offsets across the
    /// axis come from a tilted object, whose foot is elsewhere, and are ignored.
    pub(super) fn learn_held(&mut self, now: &GraspFrame) {
        let Some((felt, off_m)) = self.beside(now) else {
            return;
        };
        let held_m = felt.closing_axis.dot(&off_m);
        if !self.waypoints.joins() && held_m.abs() < DISPLACED_MAX_M.min(self.waypoints.spare_m()) {
            self.waypoints.hold_beside(held_m);
        }
    }

    /// Returns the measured object pose and its offset from the centre of the commanded hand, base
    /// frame, m.
    fn beside(&self, now: &GraspFrame) -> Option<(ObjectPose, Vector2<f64>)> {
        let felt = self.felt?;
        let [first_m, second_m] = now.half_opening_m;
        let off_m = felt.off_m + felt.closing_axis * ((first_m - second_m) / 2.0);
        Some((felt, off_m))
    }
}
