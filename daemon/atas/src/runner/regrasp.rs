//! What the runner makes of where the fingertips feel the object: grasps it there, and sets it down by that.
//!
//! ```text
//!   gripped at the source ── felt near the middle of the hand ──▶ goes on; what remains is taken off where it is set down
//!            ▲            └─ felt beside it, or turned ──▶ opens, comes again where it was felt (once) ─┐
//!            └──────────────────────────────────────────────────────────────────────────────────────────┘
//! ```
//!
//! The hand has not lifted anything yet, so opening costs nothing but time. What is felt too far from what was told to be that
//! object's error is not believed: the hand then goes on as told.

use super::{Runner, Thresholds};
use crate::limits::{DISPLACED_MAX_M, TURNED_MAX_RAD};
use crate::modules::Modules;
use crate::perception::ObjectPose;
use crate::settings::Settings;
use crate::tasks::{COME_AGAIN, Motion, Step, Transition, Waypoint};
use core::f64::consts::FRAC_PI_2;
use nalgebra::Vector2;
use robot_model::GraspFrame;

/// How far the bodies of a hand that turns may be from the axis that it turns about, m (ours: the built-in robots' palms).
const REACH_M: f64 = 0.06;
/// Where two hands join what they hold, what is felt farther from the middle of one is grasped anew, m (ours: half of what a neck
/// captures): the check of their ways counts on what they hold being there.
const JOIN_M: f64 = 0.001;

/// Whether the hand comes again, or has.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) enum Regrasp {
    /// It has grasped as told.
    #[default]
    NotYet,
    /// It comes again, and goes on with this step of its task.
    Before(usize),
    /// It has come again.
    Done,
}

impl Runner {
    /// The steps in force: those of the task, or those between its two grasps.
    pub(super) fn steps(&self) -> &[Step] {
        match self.regrasp {
            Regrasp::Before(_) => &COME_AGAIN,
            Regrasp::NotYet | Regrasp::Done => &self.track,
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
        if let Regrasp::Before(index) = self.regrasp {
            if self.index + 1 < COME_AGAIN.len() {
                return false;
            }
            self.regrasp = Regrasp::Done;
            self.enter(index, now, settings, modules);
            return true;
        }
        let Some(index) = self.search() else {
            return false;
        };
        let comes_again = self.learn_place(now, settings) && self.regrasp == Regrasp::NotYet;
        if comes_again {
            self.forget_object(settings, modules);
            self.regrasp = Regrasp::Before(index);
            self.enter(0, now, settings, modules);
        }
        comes_again
    }

    /// The step in which the search for what is now gripped began, if the hand stands at its source and has just gripped it.
    fn search(&self) -> Option<usize> {
        let step = self.step();
        if step.transition != Transition::Gripped || step.is_read_off() || self.retreat.is_some() {
            return None;
        }
        let before = &self.track[..self.index];
        let came = before
            .iter()
            .rposition(|step| step.motion != Motion::Stay)?;
        (before[came].motion == Motion::Reach(Waypoint::Source)).then_some(came + 1)
    }

    /// Takes in where the object is felt; whether that is where the hand should rather grasp it.
    fn learn_place(&mut self, now: &GraspFrame, settings: &Settings) -> bool {
        let Some((felt, off_m)) = self.beside(now) else {
            return false;
        };
        let at_m = now.centre_m.xy() + off_m;
        let from_source_m = at_m - self.waypoints.source_m();
        let displaced_m = self.displaced_m + from_source_m;
        let turned = felt.turn_rad.abs();
        // False for what is not a number.
        let believed = displaced_m.norm() < DISPLACED_MAX_M && turned < TURNED_MAX_RAD;
        let keeps_apart = displaced_m.norm() + turned * REACH_M <= self.waypoints.spare_m();
        if !(believed && keeps_apart) {
            return false;
        }
        self.displaced_m = displaced_m;
        let near_m = if self.waypoints.joins() {
            settings.grasp.regrasp_m.min(JOIN_M)
        } else {
            settings.grasp.regrasp_m
        };
        let is_far = off_m.norm() > near_m || turned > settings.grasp.regrasp_rad;
        if is_far && self.regrasp == Regrasp::NotYet {
            // A hand that comes from the side points at its object; only from above can it turn about it.
            let turns = now.hand_pitch_rad >= FRAC_PI_2;
            let turn_rad = if turns { felt.turn_rad } else { 0.0 };
            self.waypoints.come_again(&from_source_m, turn_rad);
        }
        is_far
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

    /// What was learnt of the object will be learnt again.
    fn forget_object(&mut self, settings: &Settings, modules: &mut Modules) {
        modules.let_go();
        self.thresholds =
            Thresholds::unknown(&settings.grasp).told(self.wishes.max_force_n, &settings.grasp);
        self.stiffness = None;
        self.holds = false;
    }
}
