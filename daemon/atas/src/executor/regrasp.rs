//! Regrasp: corrects the grasp from the measured object pose.
//!
//! * Object off-centre or rotated at the source: opens and regrasps at the measured place.
//! * Lift failed or object rotated, weight off-centre: puts back, opens, regrasps nearer to the
//!   centre of mass.
//! * Object too soft for its weight and rotated while probed: puts back, opens, regrasps and probes
//!   again.
//!
//! Each correction happens once; a grasp nearer to the centre of mass, a few times. Displacements
//! beyond plausible goal errors are ignored. No shift exceeds the clearance margin of the goal
//! check.

use super::{Course, TaskExecutor};
use crate::limits::{DISPLACED_MAX_M, YAW_ERROR_MAX_RAD};
use crate::modules::{Modules, Verdict};
use crate::perception::{ObjectPose, Percept};
use crate::settings::Settings;
use crate::tasks::{Motion, Step, Transition, Waypoint};
use core::f64::consts::FRAC_PI_2;
use nalgebra::Vector2;
use robot_model::GraspPose;
use shm_schemas::Reason;

/// Radius of the hand bodies about their rotation axis, m (design choice: palms of the built-in
/// robots).
const BODY_RADIUS_M: f64 = 0.06;
/// Off-centre distance that triggers a regrasp when two hands join objects, m (design choice: half
/// the capture range of a neck). The clearance check relies on the object place.
const JOIN_OFFSET_MAX_M: f64 = 0.001;
/// Number of grasps nearer to the centre of mass (design choice: an object that tilts in the hand
/// lands beside its place, so one correction is not always enough).
const BALANCES_MAX: u8 = 3;
/// Lever beyond which an object is put back, m (design choice: exceeds a place error of 2
/// mm). Otherwise it needs several times the force and rotates at the first shake.
const LEVER_MAX_M: f64 = 0.0022;
/// Maximum lift height for putting back, m (design choice, measured): objects that rotate higher up
/// may topple on release.
const PUT_BACK_MAX_M: f64 = 0.016;
/// Maximum lateral shift for a lever, m (design choice).
const SHIFT_MAX_M: f64 = 0.006;
/// Maximum offset across the closing axis of a flat object, m (design choice; measured: below 0.1
/// mm for flat faces). Round objects are graspable only about their axis.
const FLAT_OFFSET_MAX_M: f64 = 0.0003;
/// Indices in [`crate::tasks::REGRASP`]: start with a lifted object, or with a standing one.
const PUT_BACK_STEP: usize = 0;
const REOPEN_STEP: usize = 1;

/// Corrections that the task has used.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Corrections {
    /// The hand regrasped at the measured place.
    recentred: bool,
    /// Number of grasps nearer to the centre of mass.
    balances: u8,
    /// The hand regrasped to probe again.
    reprobed: bool,
    /// Number of descents that touched the object.
    pub(super) evasions: u8,
}

impl TaskExecutor {
    /// Displacement of the object from its commanded place, base frame, m; zero while unknown.
    #[must_use]
    pub fn displacement_m(&self) -> Vector2<f64> {
        self.displacement_m
    }

    /// Starts or continues a regrasp at the end of a step. Returns true if it entered another step.
    pub(super) fn advance_regrasp(
        &mut self,
        now: &GraspPose,
        settings: &Settings,
        modules: &mut Modules,
    ) -> bool {
        if matches!(self.course, Course::Regrasp { .. }) && self.index == PUT_BACK_STEP {
            self.reopen(now, settings, modules);
            return true;
        }
        if self.step().transition != Transition::Gripped {
            return false;
        }
        let Some(resume_step) = self.search_step() else {
            return false;
        };
        let comes_again = self.update_place(now, settings);
        if comes_again {
            self.course = Course::Regrasp { resume_step };
            self.reopen(now, settings, modules);
        }
        comes_again
    }

    /// Releases the standing object and resets its thresholds and stiffness.
    fn reopen(&mut self, now: &GraspPose, settings: &Settings, modules: &mut Modules) {
        modules.release_object();
        let thresholds = self.parameters.initial_thresholds(settings);
        self.object.reset_probe(thresholds);
        self.enter(REOPEN_STEP, now, settings, modules);
    }

    /// Returns true if the lift is rejected or out of force, or the object rotates or has too long
    /// a lever.
    fn lift_fails(&self, verdict: Verdict, percept: &Percept) -> bool {
        let is_obstructed = matches!(verdict, Verdict::Refuse(Reason::Obstructed { .. }));
        let is_refused = matches!(verdict, Verdict::Refuse(_)) && !is_obstructed;
        let hangs_askew = !self.object.is_verified()
            && self.object.lever_is_known()
            && self.object.lever_m().abs() > LEVER_MAX_M;
        is_refused
            || hangs_askew
            || self.turning().is_some()
            || self.out_of_force(percept).is_some()
    }

    /// Puts back an object that cannot be lifted, for a shifted grasp or another probe. Returns
    /// true if it did.
    pub(super) fn start_regrasp(
        &mut self,
        verdict: Verdict,
        percept: &Percept,
        now: &GraspPose,
        settings: &Settings,
        modules: &mut Modules,
    ) -> bool {
        let lifts = self.step().motion == Motion::Carry(Waypoint::Lifted);
        let is_low = self.object.object().carried_m < PUT_BACK_MAX_M;
        if !(lifts && is_low) || self.object.is_found() || self.waypoints.joins_objects() {
            return false;
        }
        if !self.lift_fails(verdict, percept) {
            return false;
        }
        let Some(resume_step) = self.search_step() else {
            return false;
        };
        let aside = self.lateral_shift(settings);
        if aside.is_some() {
            // If the object proves to be round, the hand returns to its centre.
            self.corrections.recentred = false;
            self.corrections.balances += 1;
        } else if self.needs_reprobe(verdict) {
            self.corrections.reprobed = true;
        } else {
            return false;
        }
        self.course = Course::Regrasp { resume_step };
        // Motion on the way back counts neither as slip nor as rotation.
        self.object.let_go();
        self.object.restart_in_hand();
        self.enter(PUT_BACK_STEP, now, settings, modules);
        if let Some((aside_m, axis)) = aside {
            self.waypoints.shift_grasp(aside_m, &axis);
        }
        true
    }

    /// Returns the lateral shift towards the centre of mass, m, and the closing axis.
    fn lateral_shift(&self, settings: &Settings) -> Option<(f64, Vector2<f64>)> {
        let measured = self
            .object_pose
            .filter(|_| self.corrections.balances < BALANCES_MAX)?;
        let across_m = measured.closing_axis.perp(&measured.offset_m);
        let lever_m = self.object.lever_m();
        let aside_m = lever_m.clamp(-SHIFT_MAX_M, SHIFT_MAX_M);
        let has_room =
            self.displacement_m.norm() + aside_m.abs() <= self.waypoints.clearance_margin_m();
        // False for NaN.
        let is_flat = across_m.abs() < FLAT_OFFSET_MAX_M;
        let goes = lever_m.abs() >= settings.grasp.regrasp_lever_m && has_room && is_flat;
        goes.then_some((aside_m, measured.closing_axis))
    }

    /// Returns true once if the object was rejected as too soft but may have rotated against the
    /// fingertips.
    fn needs_reprobe(&self, verdict: Verdict) -> bool {
        let too_soft = matches!(verdict, Verdict::Refuse(Reason::TooSoft { .. }));
        let settled = self.object.stiffness().is_some_and(|fit| fit.new_contact);
        too_soft && settled && !self.corrections.reprobed
    }

    /// Returns the step that searched for the object, if the hand came to the source for it and
    /// went nowhere else since.
    fn search_step(&self) -> Option<usize> {
        if self.step().uses_table() || self.recovery_reason().is_some() {
            return None;
        }
        let stays =
            |step: &Step| matches!(step.motion, Motion::Stay | Motion::Carry(Waypoint::Lifted));
        let before = &self.sequence[..self.index];
        let came = before.iter().rposition(|step| !stays(step))?;
        (before[came].motion == Motion::Reach(Waypoint::Source)).then_some(came + 1)
    }

    /// Updates the displacement of the object and returns true if the hand must regrasp at the
    /// measured place.
    fn update_place(&mut self, now: &GraspPose, settings: &Settings) -> bool {
        let Some((measured, off_m)) = self.object_offset(now) else {
            return false;
        };
        let at_m = now.centre_m.xy() + off_m;
        let displaced_m = at_m - self.waypoints.commanded_m();
        let turned = measured.yaw_error_rad.abs();
        // False for NaN.
        let believed = displaced_m.norm() < DISPLACED_MAX_M && turned < YAW_ERROR_MAX_RAD;
        let has_room =
            displaced_m.norm() + turned * BODY_RADIUS_M <= self.waypoints.clearance_margin_m();
        if !(believed && has_room) {
            return false;
        }
        self.displacement_m = displaced_m;
        let near_m = if self.waypoints.joins_objects() {
            settings.grasp.regrasp_m.min(JOIN_OFFSET_MAX_M)
        } else {
            settings.grasp.regrasp_m
        };
        let is_far = off_m.norm() > near_m || turned > settings.grasp.regrasp_rad;
        if !is_far || self.corrections.recentred {
            return false;
        }
        // Only a hand from above can rotate about the object; a side grasp must point at it.
        let turns = now.hand_pitch_rad >= FRAC_PI_2;
        let turn_rad = if turns { measured.yaw_error_rad } else { 0.0 };
        self.waypoints.move_grasp(&at_m, turn_rad);
        self.corrections.recentred = true;
        true
    }

    /// Updates the offset of the held object along the closing axis for placing. Offsets across the
    /// axis come from a tilted object, whose foot is elsewhere, and are ignored.
    pub(super) fn update_held_offset(&mut self, now: &GraspPose) {
        let Some((measured, off_m)) = self.object_offset(now) else {
            return;
        };
        let held_m = measured.closing_axis.dot(&off_m);
        if !self.waypoints.joins_objects()
            && held_m.abs() < DISPLACED_MAX_M.min(self.waypoints.clearance_margin_m())
        {
            self.waypoints.set_held_offset(held_m);
        }
    }

    /// Returns the measured object pose and its offset from the centre of the commanded hand, base
    /// frame, m.
    fn object_offset(&self, now: &GraspPose) -> Option<(ObjectPose, Vector2<f64>)> {
        let measured = self.object_pose?;
        let [first_m, second_m] = now.half_opening_m.into_array();
        let off_m = measured.offset_m + measured.closing_axis * ((first_m - second_m) / 2.0);
        Some((measured, off_m))
    }
}
