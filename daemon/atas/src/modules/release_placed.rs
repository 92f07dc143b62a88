//! Module 4, placing (paper II.b (3)): "releases the object when the tactile sensors catch the upward tangential force.
//! If the robotic hand feels upward tangential force while moving down, the object's bottom has touched a table or a
//! floor. In this module, the upward tangential force induces opening the hand."
//!
//! The vertical force of the object on all fingertips, in the base frame, is held against a reference that follows it
//! slowly. After the descent has settled, a rise of `place.rise_n`, or `place.rise_share` of the held weight if that is
//! more, in `place.rise_frames` frames in a row concludes the step.

use super::{Context, Module, Proposal, Verdict, force_up_n};
use crate::perception::Percept;

/// Time constant of the reference while the descent settles, s (prototype: 50 ms).
const SETTLING_FILTER_S: f64 = 0.05;
/// Time constant of the reference afterwards, s (prototype: 500 ms; faster would follow a slow landing).
const REFERENCE_FILTER_S: f64 = 0.5;

/// What the module remembers of one descent.
#[derive(Clone, Debug, Default)]
pub(super) struct ReleasePlaced {
    descent_s: f64,
    reference_n: Option<f64>,
    rising_frames: f64,
}

impl Module for ReleasePlaced {
    fn evaluate(&mut self, percept: &Percept, context: &Context<'_>) -> Proposal {
        let settings = &context.settings.place;
        if context.lowering_m.is_none() {
            return Proposal::default();
        }
        self.descent_s += context.step_s;
        let up_n = force_up_n(percept, context);
        let reference_n = *self.reference_n.get_or_insert(up_n);
        let settled = self.descent_s > settings.settle_s;
        let limit_n = settings.rise_n.max(settings.rise_share * reference_n.abs());
        let rises = settled && up_n - reference_n > limit_n;
        let new_frames = if percept.step_s > 0.0 { 1.0 } else { 0.0 };
        self.rising_frames = if rises {
            self.rising_frames + new_frames
        } else {
            0.0
        };
        if !rises {
            let filter_s = if settled {
                REFERENCE_FILTER_S
            } else {
                SETTLING_FILTER_S
            };
            let share = context.step_s / (filter_s + context.step_s);
            self.reference_n = Some(reference_n + (up_n - reference_n) * share);
        }
        let placed = self.rising_frames >= settings.rise_frames;
        Proposal {
            active: rises,
            verdict: if placed { Verdict::Done } else { Verdict::None },
            ..Proposal::default()
        }
    }
}
