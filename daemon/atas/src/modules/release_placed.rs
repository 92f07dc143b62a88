//! Module 4, placing (paper II.b (3)): "releases the object when the tactile sensors catch the
//! upward tangential force. If the robotic hand feels upward tangential force while moving down,
//! the object's bottom has touched a table or a floor. In this module, the upward tangential force
//! induces opening the hand."
//!
//! The vertical force of the object on all fingertips, base frame, is compared with a slowly
//! adapting reference. After the descent has settled, a rise above the limit for `place.rise_s`
//! ends the step: three frames of a fast sensor, or one of a slow one. The limit is the largest of
//! `place.rise_n`, `place.rise_share` of the held weight, and a multiple of the measured scatter.
//!
//! A stop makes the object swing, which imitates or hides a support. The hand waits until the swing
//! has ended.

use super::{Context, Module, Proposal, Roles, Verdict, force_up_n};
use crate::perception::Percept;
use shm_schemas::ModuleId;

/// Time constant of the reference while the descent settles, s (prototype: 50 ms).
const SETTLING_FILTER_S: f64 = 0.05;
/// Time constant of the reference afterwards, s (prototype: 500 ms). A shorter one would follow a
/// slow landing.
const REFERENCE_FILTER_S: f64 = 0.5;
/// Time constant of the scatter, s (design choice: several periods of hand vibration).
const SCATTER_FILTER_S: f64 = 0.5;
/// Standard deviations of the scatter that are ignored (design choice: one false alarm in about ten
/// thousand frames).
const SCATTER_MARGIN: f64 = 4.0;
/// Swing time of a load after a stop, s (design choice).
const SWING_S: f64 = 0.15;

#[derive(Clone, Copy, Debug, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct ReleasePlaced {
    descent_s: f64,
    reference_n: Option<f64>,
    /// Variance of the force around its reference, N².
    scatter_n2: f64,
    /// Sensor time above the limit, s.
    rising_s: f64,
    /// Remaining swing time, s.
    swing_s: f64,
}

impl Module for ReleasePlaced {
    const ID: ModuleId = ModuleId::RELEASE_PLACED;
    const ROLES: Roles = Roles {
        concludes: true,
        resets_each_step: true,
        ..Roles::NONE
    };

    fn evaluate(&mut self, percept: &Percept, context: &Context<'_>) -> Proposal {
        let settings = &context.settings.place;
        if context.lowering_m.is_none() {
            return Proposal::default();
        }
        if self.swing_s > 0.0 {
            self.swing_s -= context.step_s;
            return Proposal {
                active: true,
                carry_ceiling: 0.0,
                ..Proposal::default()
            };
        }
        self.descent_s += context.step_s;
        let up_n = force_up_n(percept, context.base_from_tip);
        let reference_n = *self.reference_n.get_or_insert(up_n);
        let settled = self.descent_s > settings.settle_s;
        let limit_n = settings
            .rise_n
            .max(settings.rise_share * reference_n.abs())
            .max(SCATTER_MARGIN * libm::sqrt(self.scatter_n2));
        let rises = settled && up_n - reference_n > limit_n;
        if rises {
            self.rising_s += percept.step_s;
        } else {
            self.rising_s = 0.0;
            self.update_scatter(up_n - reference_n, percept.step_s);
            let filter_s = if settled {
                REFERENCE_FILTER_S
            } else {
                SETTLING_FILTER_S
            };
            let share = context.step_s / (filter_s + context.step_s);
            self.reference_n = Some(reference_n + (up_n - reference_n) * share);
        }
        let placed = self.rising_s >= settings.rise_s;
        Proposal {
            active: rises,
            verdict: if placed { Verdict::Done } else { Verdict::None },
            ..Proposal::default()
        }
    }
}

impl ReleasePlaced {
    /// Starts the swing time after a stop.
    pub(super) fn stop(&mut self) {
        (self.swing_s, self.rising_s) = (SWING_S, 0.0);
    }

    fn update_scatter(&mut self, off_n: f64, step_s: f64) {
        let share = step_s / (SCATTER_FILTER_S + step_s);
        self.scatter_n2 += (off_n * off_n - self.scatter_n2) * share;
    }
}
