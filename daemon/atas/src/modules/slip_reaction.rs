//! Slip reaction, a baseline for comparison with the paper's modules: the force target rises by a
//! fixed share whenever the object slips, after J. M. Romano, K. Hsiao, G. Niemeyer, S. Chitta and
//! K. J. Kuchenbecker, "Human-inspired robotic grasp control with tactile sensing", IEEE
//! Transactions on Robotics 27(6), 2011.
//!
//! It uses neither stiffness nor F_2, starts at F_1 and never reduces force. No built-in task
//! selects it. Slip is detected by the friction utilisation of Module 2 instead of the published
//! high-pass filtered forces and accelerometer. The comparison therefore covers the control law
//! only.

use super::{Context, Module, Proposal, Roles};
use crate::perception::{ContactPercept, Percept};
use crate::settings::Grasp;
use robot_model::PerSide;
use shm_schemas::ModuleId;

/// Rise of the target per sample with slip: 8 %, that is 0.2 % per millisecond over the 41 ms
/// sample of the pressure sensors in the authors' PR2 controller.
const RAISE_SHARE: f64 = 0.08;
/// Duration of one sample, s.
const SAMPLE_S: f64 = 0.041;

/// State of the module.
#[derive(Clone, Copy, Debug, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct SlipReaction {
    /// Force target relative to F_1, minus one.
    raised: f64,
    /// Time since the last rise of the target, s.
    since_s: f64,
}

impl Module for SlipReaction {
    const ID: ModuleId = ModuleId::SLIP_REACTION;
    const ROLES: Roles = Roles {
        closes_fingers: true,
        ..Roles::NONE
    };

    fn evaluate(&mut self, percept: &Percept, context: &Context<'_>) -> Proposal {
        let settings = &context.settings.grasp;
        self.since_s += context.step_s;
        let mut fingers = percept.sides.iter();
        let slips = context.object.all_touched && fingers.any(|finger| slips(finger, settings));
        if slips && self.since_s >= SAMPLE_S {
            self.raised = (1.0 + self.raised) * (1.0 + RAISE_SHARE) - 1.0;
            self.since_s = 0.0;
        }
        let (weakest_n, _) = percept.normal_range_n();
        let target_n = context.object.thresholds.f1_n * (1.0 + self.raised);
        let active = context.object.all_touched && weakest_n <= target_n;
        Proposal {
            active,
            closing_m_s: PerSide::repeat(if active { settings.enhance_m_s } else { 0.0 }),
            ..Proposal::default()
        }
    }
}

fn slips(finger: &ContactPercept, settings: &Grasp) -> bool {
    finger.utilisation > settings.slip_on || finger.gross_slip_s > settings.slip_gross_s
}
