//! Module 4, screwing (paper II.b (2)): "Empirically, we know that much slippage occurs when the
//! cap is tightened. If increment of shearing force dF_t exceeds 1.4 times of dF_max, which is the
//! maximum of dF_t during the first touch, the finger motion is terminated."
//!
//! Here, dF_t is the mean shear force against the turn, minus its value at the start of the turn if
//! positive (closing may drag the cap back). "The first touch" is the first turn. A shorter window
//! stops early or never (prototype).

use super::{Context, Module, Proposal, Roles, Verdict};
use crate::perception::Percept;
use nalgebra::Vector3;
use robot_model::GRASP_SIDES;
use shm_schemas::ModuleId;

#[derive(Clone, Copy, Debug, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct TerminateScrew {
    /// Filtered shear force, N.
    shear_n: f64,
    /// Filtered shear force at the start of the turn, N.
    start_shear_n: f64,
    /// dF_max, N.
    increment_max_n: f64,
    first_turn_done: bool,
    /// Previous position of the first side along the turn, m.
    last_m: Option<f64>,
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
        let share = context.step_s / (settings.finish_filter_s + context.step_s);
        self.shear_n += (shear_n(percept, context) - self.shear_n) * share;
        let turned_m = context.turning * context.pose.tangential_m[0];
        let moved_m = turned_m - self.last_m.replace(turned_m).unwrap_or(turned_m);
        let gripping = percept.sides.iter().all(|f| f.in_contact);
        self.first_turn_done |= moved_m < 0.0 && self.increment_max_n > 0.0;
        if moved_m <= 0.0 || !gripping {
            self.start_shear_n = self.shear_n.max(0.0);
            return Proposal::default();
        }
        let increment_n = self.shear_n - self.start_shear_n;
        if !self.first_turn_done && increment_n > self.increment_max_n {
            self.increment_max_n = increment_n;
        }
        let tight =
            self.first_turn_done && increment_n > settings.finish_ratio * self.increment_max_n;
        Proposal {
            active: tight,
            verdict: if tight { Verdict::Done } else { Verdict::None },
            ..Proposal::default()
        }
    }
}

/// Returns the mean tangential force against the turn, N, in the patch frame, which excludes the
/// curvature of the fingertip.
fn shear_n(percept: &Percept, context: &Context<'_>) -> f64 {
    let n = context.closing_axis;
    let ahead = Vector3::new(-n.y, n.x, 0.0) * context.turning;
    let fingers = percept.fingertips.iter().zip(context.base_from_tip);
    // The first side moves ahead, the second back.
    let against = fingers
        .zip(percept.side_of_fingertip)
        .map(|((finger, base_from_tip), side)| {
            let sign = if side == 0 { -1.0 } else { 1.0 };
            let tangential_n = finger.force_tip_n + finger.patch_normal * finger.normal_n;
            sign * (base_from_tip * tangential_n).dot(&ahead)
        });
    against.sum::<f64>() / GRASP_SIDES as f64
}
