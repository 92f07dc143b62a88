//! What the runner makes of where the fingertips feel the object: grasps it there, and sets it down by that.
//!
//! ```text
//!   gripped at the source ── felt beside the middle of the hand, or turned ──────▶ opens, comes again where it was felt
//!   could not be lifted, or turned in the hand ── its weight hangs beside the grip ──▶ puts it back, opens, comes again
//!                                                                                      nearer to its centre of mass
//!   seemed too soft for its weight ── turned against the fingertips while probed ────▶ puts it back, opens, comes again
//!                                                                                      to what lies against them now
//! ```
//!
//! Each of them once: what still fails then fails. An object that stands costs nothing but time. What is felt too far from what was
//! told to be that object's error is not believed, and no hand goes farther aside than the check of the goal has found room for.

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

/// How far the bodies of a hand that turns may be from the axis that it turns about, m (ours: the built-in robots' palms).
const REACH_M: f64 = 0.06;
/// Where two hands join what they hold, what is felt farther from the middle of one is grasped anew, m (ours: half of what a neck
/// captures): the check of their ways counts on what they hold being there.
const JOIN_M: f64 = 0.001;
/// How far the hand goes aside over the lever that it felt (ours, measured): an object that turns in the hand swings its weight
/// nearer to the grip, so the lever is felt too short.
const LEVER_GAIN: f64 = 1.5;
/// Lever from which on an object that hangs just above its support is put back although it is held, m (ours: more than a place that
/// is wrong by 2 mm makes): it would need several times the force, and turn with the first shake.
const HANGS_ASKEW_M: f64 = 0.0022;
/// Height up to which it is put back, m (ours, measured): what turns farther up may have turned so far that it falls over where it
/// is let go.
const PUT_BACK_MAX_M: f64 = 0.016;
/// Farthest that it goes aside for a lever, m (ours).
const ASIDE_MAX_M: f64 = 0.006;
/// How far across the closing axis the middle of what is held may be felt for its faces to be flat, m (ours, measured: of flat faces
/// less than 0.1 mm). A round object can be grasped about its axis only.
const ROUND_M: f64 = 0.0003;
/// Where the hand comes again from, among the steps of [`COME_AGAIN`]: with what it lifts, or with what still stands.
const PUT_BACK: usize = 0;
const REOPEN: usize = 1;

/// Whether the hand comes again, and why it has.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Regrasp {
    /// It comes again, and goes on with this step of its task.
    before: Option<usize>,
    /// It has come again to where the object was felt to stand.
    placed: bool,
    /// It has come again nearer to the object's centre of mass.
    balanced: bool,
    /// It has come again to feel anew how stiff the object is.
    probed: bool,
}

impl Runner {
    /// The steps in force: those of the task, or those between two of its grasps.
    pub(super) fn steps(&self) -> &[Step] {
        match self.regrasp.before {
            Some(_) => &COME_AGAIN,
            None => &self.track,
        }
    }

    /// How far the object stood from where it was told, base frame, m; zero while nothing is known.
    #[must_use]
    pub fn displaced_m(&self) -> Vector2<f64> {
        self.displaced_m
    }

    /// At the end of a step: whether another begins than the next of the task, because the hand comes again or has done so.
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

    /// Lets go of what stands; what was learnt of it will be learnt again.
    fn reopen(&mut self, now: &GraspFrame, settings: &Settings, modules: &mut Modules) {
        modules.let_go();
        self.thresholds = self.wishes.thresholds_before_touch(settings);
        self.stiffness = None;
        self.enter(REOPEN, now, settings, modules);
    }

    /// Whether the lift goes badly: refused, out of force, turning in the hand, or hanging too far beside the grip just above its
    /// support.
    fn lifts_badly(&self, verdict: Verdict, percept: &Percept) -> bool {
        let is_refused =
            matches!(verdict, Verdict::Refuse(reason) if reason.cause != Cause::OBSTRUCTED);
        let hangs_askew = self.tries && self.in_hand.lever_m().abs() > HANGS_ASKEW_M;
        is_refused || hangs_askew || self.turns().is_some() || self.out_of_force(percept).is_some()
    }

    /// Whether an object that cannot be lifted as it is held is put back, to be grasped nearer to its centre of mass, or to be
    /// probed again.
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
            // Should it be round after all, the hand comes back to its middle.
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
        // What becomes of it on its way back is no slip and no turn of the next grasp.
        (self.holds, self.in_hand) = (false, InHand::default());
        self.enter(PUT_BACK, now, settings, modules);
        if let Some((aside_m, axis)) = aside {
            self.waypoints.grasp_aside(aside_m, &axis);
        }
        true
    }

    /// How far aside of the closing axis, and which that is, the object is grasped nearer to its centre of mass, m; once.
    fn aside(&self, settings: &Settings) -> Option<(f64, Vector2<f64>)> {
        let felt = self.felt.filter(|_| !self.regrasp.balanced)?;
        let across_m = felt.closing_axis.perp(&felt.off_m);
        let lever_m = self.in_hand.lever_m();
        let aside_m = (lever_m * LEVER_GAIN).clamp(-ASIDE_MAX_M, ASIDE_MAX_M);
        let has_room = self.displaced_m.norm() + aside_m.abs() <= self.waypoints.spare_m();
        // False for what is not a number.
        let is_flat = across_m.abs() < ROUND_M;
        let goes = lever_m.abs() >= settings.grasp.regrasp_lever_m && has_room && is_flat;
        goes.then_some((aside_m, felt.closing_axis))
    }

    /// Whether it was refused as too soft for its weight although it may only have turned against the fingertips; once.
    fn is_to_be_probed_again(&self, verdict: Verdict) -> bool {
        let too_soft =
            matches!(verdict, Verdict::Refuse(reason) if reason.cause == Cause::TOO_SOFT);
        let settled = self.stiffness.is_some_and(|fit| fit.settled);
        too_soft && settled && !self.regrasp.probed
    }

    /// The step in which the search for what the hand grips began, if it has come to its source for that and gone nowhere else yet.
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

    /// Takes in where the object is felt; whether that is where the hand comes again for it.
    fn learn_place(&mut self, now: &GraspFrame, settings: &Settings) -> bool {
        let Some((felt, off_m)) = self.beside(now) else {
            return false;
        };
        let at_m = now.centre_m.xy() + off_m;
        let displaced_m = at_m - self.waypoints.told_m();
        let turned = felt.turn_rad.abs();
        // False for what is not a number.
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
        // A hand that comes from the side points at its object; only from above can it turn about it.
        let turns = now.hand_pitch_rad >= FRAC_PI_2;
        let turn_rad = if turns { felt.turn_rad } else { 0.0 };
        self.waypoints.grasp_at(&at_m, turn_rad);
        self.regrasp.placed = true;
        true
    }

    /// Takes in how far beside the middle of the hand, along its closing axis, it carries the object: for where it sets it down.
    /// Across that axis nothing is taken in: what hangs beside the grip there hangs askew, and its foot is not below it.
    pub(super) fn learn_held(&mut self, now: &GraspFrame) {
        let Some((felt, off_m)) = self.beside(now) else {
            return;
        };
        let held_m = felt.closing_axis.dot(&off_m);
        if !self.waypoints.joins() && held_m.abs() < DISPLACED_MAX_M.min(self.waypoints.spare_m()) {
            self.waypoints.hold_beside(held_m);
        }
    }

    /// What the fingertips feel, and how far beside the middle of the commanded hand that is, base frame, m.
    fn beside(&self, now: &GraspFrame) -> Option<(ObjectPose, Vector2<f64>)> {
        let felt = self.felt?;
        let [first_m, second_m] = now.half_opening_m;
        let off_m = felt.off_m + felt.closing_axis * ((first_m - second_m) / 2.0);
        Some((felt, off_m))
    }
}
