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
use robot_model::VIRTUAL_FINGERS;
use shm_schemas::ModuleId;

#[derive(Clone, Copy, Debug, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct TerminateScrew {
    /// Filtered shear force, N.
    shear_n: f64,
    /// Filtered shear force at the start of the turn, N.
    at_grip_n: f64,
    /// dF_max, N.
    most_n: f64,
    turned_before: bool,
    /// Previous position of the first side along the turn, m.
    last_m: Option<f64>,
}

impl Module for TerminateScrew {
    const ID: ModuleId = ModuleId::TERMINATE_SCREW;
    const ROLES: Roles = Roles {
        concludes: true,
        forgets_each_step: true,
        ..Roles::NONE
    };

    fn evaluate(&mut self, percept: &Percept, context: &Context<'_>) -> Proposal {
        let settings = &context.settings.screw;
        let share = context.step_s / (settings.finish_filter_s + context.step_s);
        self.shear_n += (shear_n(percept, context) - self.shear_n) * share;
        let turned_m = context.turning * context.frame.tangential_m[0];
        let moved_m = turned_m - self.last_m.replace(turned_m).unwrap_or(turned_m);
        let gripping = percept.virtual_fingers.iter().all(|f| f.in_contact);
        self.turned_before |= moved_m < 0.0 && self.most_n > 0.0;
        if moved_m <= 0.0 || !gripping {
            self.at_grip_n = self.shear_n.max(0.0);
            return Proposal::default();
        }
        let increment_n = self.shear_n - self.at_grip_n;
        if !self.turned_before && increment_n > self.most_n {
            self.most_n = increment_n;
        }
        let tight = self.turned_before && increment_n > settings.finish_ratio * self.most_n;
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
    let fingers = percept.fingers.iter().zip(context.base_from_tip);
    // The first side moves ahead, the second back.
    let against = fingers
        .zip(percept.presses_from)
        .map(|((finger, base_from_tip), side)| {
            let sign = if side == 0 { -1.0 } else { 1.0 };
            let tangential_n = finger.force_tip_n + finger.patch_normal * finger.normal_n;
            sign * (base_from_tip * tangential_n).dot(&ahead)
        });
    against.sum::<f64>() / VIRTUAL_FINGERS as f64
}
