//! Module 4, placing (paper II.b (3)): "releases the object when the tactile sensors catch the
//! upward tangential force. If the robotic hand feels upward tangential force while moving down,
//! the object's bottom has touched a table or a floor. In this module, the upward tangential force
//! induces opening the hand."
//!
//! The vertical force of the object on all fingertips, base frame, is compared with a slowly
//! adapting reference. After the descent has settled, a rise above the limit for `place.rise_s`
//! ends the step: three frames of a fast sensor, or two of a slow one. The limit is the largest of
//! `place.rise_n`, `place.rise_share` of the held weight, and a multiple of the measured scatter.
//!
//! A stop makes the object swing, which imitates or hides a support. The hand waits until the swing
//! has ended.

use super::{Context, Module, Proposal, Roles, Verdict};
use crate::filter::low_pass;
use crate::perception::Percept;
use shm_schemas::ModuleId;

/// Time constant of the reference while the descent settles, s (prototype: 50 ms).
const SETTLING_FILTER_S: f64 = 0.05;
/// Lowering distance that gives the time constant of the reference afterwards, and of the scatter,
/// m (prototype: 500 ms at 10 mm/s). A shorter one would follow a soft landing.
const ADAPTATION_TRAVEL_M: f64 = 0.005;
/// Standard deviations of the scatter that are ignored (design choice: one false alarm in about ten
/// thousand frames).
const SCATTER_MARGIN: f64 = 4.0;
/// Smallest number of consecutive frames above the limit (design choice: with one, noise at 30 Hz
/// drops one light object of ten in the air).
const RISING_FRAMES_MIN: u32 = 2;
/// Largest lowering distance from the touch of the support until the release, m. Design choice:
/// sensors of 400 Hz and more allow `place.lower_m_s`.
const TOUCH_TRAVEL_M: f64 = 0.0001;
/// Swing time of a load after a stop, s (design choice).
const SWING_S: f64 = 0.15;

#[derive(Clone, Copy, Debug, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct ReleasePlaced {
    descent_s: f64,
    reference_n: Option<f64>,
    /// Variance of the force around its reference, N².
    scatter_n2: f64,
    /// Sensor time and number of consecutive frames above the limit, s.
    rising_s: f64,
    rising_frames: u32,
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
        let up_n = -context.object.down_n;
        let reference_n = *self.reference_n.get_or_insert(up_n);
        let settled = self.descent_s > settings.settle_s;
        let limit_n = settings
            .rise_n
            .max(settings.rise_share * reference_n.abs())
            .max(SCATTER_MARGIN * libm::sqrt(self.scatter_n2));
        let rises = settled && up_n - reference_n > limit_n;
        if rises {
            self.rising_s += percept.step_s;
            self.rising_frames += u32::from(percept.step_s > 0.0);
        } else {
            (self.rising_s, self.rising_frames) = (0.0, 0);
            let slow_s = ADAPTATION_TRAVEL_M / lowering_speed_m_s(percept, context);
            self.update_scatter(up_n - reference_n, percept.step_s, slow_s);
            let filter_s = if settled { slow_s } else { SETTLING_FILTER_S };
            self.reference_n = Some(low_pass(reference_n, up_n, context.step_s, filter_s));
        }
        let placed = self.rising_s >= settings.rise_s && self.rising_frames >= RISING_FRAMES_MIN;
        Proposal {
            active: rises,
            verdict: if placed { Verdict::Done } else { Verdict::None },
            ..Proposal::default()
        }
    }
}

/// Returns the lowering speed, m/s: `place.lower_m_s`, or less if the frames arrive too rarely for
/// a gentle touch.
pub(super) fn lowering_speed_m_s(percept: &Percept, context: &Context<'_>) -> f64 {
    let settings = context.settings;
    let gentle_m_s = percept.touch_speed_m_s(TOUCH_TRAVEL_M, RISING_FRAMES_MIN, settings);
    settings.place.lower_m_s.min(gentle_m_s)
}

impl ReleasePlaced {
    /// Starts the swing time after a stop.
    pub(super) fn stop(&mut self) {
        self.swing_s = SWING_S;
        (self.rising_s, self.rising_frames) = (0.0, 0);
    }

    fn update_scatter(&mut self, off_n: f64, step_s: f64, filter_s: f64) {
        // At first, all frames count equally.
        let filter_s = filter_s.min(self.descent_s);
        self.scatter_n2 = low_pass(self.scatter_n2, off_n * off_n, step_s, filter_s);
    }
}
