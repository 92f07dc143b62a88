//! Module 4, screwing (paper II.b (2)): "Empirically, we know that much slippage occurs when the
//! cap is tightened. If increment of shearing force dF_t exceeds 1.4 times of dF_max, which is the
//! maximum of dF_t during the first touch, the finger motion is terminated."
//!
//! Here, dF_t is the cap's torque against the turn over the distance of the sides, which does not
//! change. The module therefore compares torques. A finger that only holds the cap exerts none, so
//! the torque itself is the increment. "The first touch" is the first turn. A shorter window stops
//! early or never (prototype).
//!
//! The torque is about the vertical through the hand's centre, which is the cap's axis:
//!
//! ```text
//! T = Σ over fingertips (τ + (o − c) × F)·z
//! ```
//!
//! F and τ are force and torque about the fingertip's origin o; c is the centre between the sides.
//! Forces through the axis have no torque. A sum of shear forces would include a part of the normal
//! force where a fingertip rolls on the cap.

use super::trajectory::ENGAGED_DESCENT_M;
use super::{Context, Module, Proposal, Roles, Verdict};
use crate::filter::low_pass;
use crate::perception::{ContactPercept, Percept};
use robot_model::{GraspSide, Transform};
use shm_schemas::ModuleId;

#[derive(Clone, Copy, Debug, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct TerminateScrew {
    /// Filtered torque, N·m.
    torque_n_m: f64,
    /// dF_max as a torque, N·m.
    first_max_n_m: f64,
    first_turn_done: bool,
    /// Previous position of the first side along the turn, m.
    last_m: Option<f64>,
    /// Height of the hand at the start of the turn, m.
    start_height_m: Option<f64>,
}

impl Module for TerminateScrew {
    const ID: ModuleId = ModuleId::TERMINATE_SCREW;
    const ROLES: Roles = Roles {
        concludes: true,
        resets_each_step: true,
        ..Roles::NONE
    };

    fn evaluate(&mut self, percept: &Percept, context: &Context<'_>) -> Proposal {
        let settings = &context.settings.screw;
        let torque_n_m = -context.turning * torque_n_m(percept, context);
        let filter_s = settings.finish_filter_s;
        self.torque_n_m = low_pass(self.torque_n_m, torque_n_m, context.step_s, filter_s);
        let turned_m = context.turning * context.hand.pose.tangential_m[GraspSide::First];
        let moved_m = turned_m - self.last_m.replace(turned_m).unwrap_or(turned_m);
        let gripping = percept.sides.iter().all(|f| f.in_contact);
        if moved_m < 0.0 {
            self.end_turn(context);
        }
        if moved_m <= 0.0 || !gripping {
            return Proposal::default();
        }
        let height_m = context.hand.pose.centre_m.z;
        self.start_height_m.get_or_insert(height_m);
        if !self.first_turn_done && self.torque_n_m > self.first_max_n_m {
            self.first_max_n_m = self.torque_n_m;
        }
        let tight =
            self.first_turn_done && self.torque_n_m > settings.finish_ratio * self.first_max_n_m;
        Proposal {
            active: tight,
            verdict: if tight { Verdict::Done } else { Verdict::None },
            ..Proposal::default()
        }
    }
}

impl TerminateScrew {
    /// Ends a turn. A cap that did not descend was not on its thread: its turn does not count.
    fn end_turn(&mut self, context: &Context<'_>) {
        let Some(start_m) = self.start_height_m.take() else {
            return;
        };
        let descent_m = start_m - context.hand.pose.centre_m.z;
        if !self.first_turn_done && descent_m < ENGAGED_DESCENT_M {
            self.first_max_n_m = 0.0;
        }
        self.first_turn_done |= self.first_max_n_m > 0.0;
    }
}

/// Returns the torque of the object about the vertical through the hand's centre, N·m; positive is
/// anticlockwise from above.
fn torque_n_m(percept: &Percept, context: &Context<'_>) -> f64 {
    let centre_m =
        (context.hand.side_m[GraspSide::First] + context.hand.side_m[GraspSide::Second]) / 2.0;
    let of_fingertip = |(finger, tip): (&ContactPercept, &Transform)| {
        let force_n = tip.rotation * finger.force_tip_n;
        let torque_n_m = tip.rotation * finger.torque_tip_n_m;
        (torque_n_m + (tip.translation_m - centre_m).cross(&force_n)).z
    };
    let fingertips = percept.fingertips.iter().zip(context.hand.base_from_tip);
    fingertips.map(of_fingertip).sum()
}
