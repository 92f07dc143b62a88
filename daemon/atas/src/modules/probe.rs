//! Hardness probe (paper II.b (1)): "After the first touch during 100 msec, the robot measures the object's hardness.
//! Based on the hardness, threshold F_2 is specified."
//!
//! All fingers close at the approach speed for the probe's duration; the verdict is the fit, or, when the forces tell
//! nothing, no verdict at all: the fingers stop and the step times out rather than guess.

use super::{Context, Module, Proposal, Verdict, force_range_n};
use crate::perception::{Hardness, Percept};
use robot_model::FINGERS;

/// The samples so far.
#[derive(Clone, Debug, Default)]
pub(super) struct Probe {
    elapsed_s: f64,
    hardness: Hardness,
}

impl Module for Probe {
    fn evaluate(&mut self, percept: &Percept, context: &Context<'_>) -> Proposal {
        let settings = &context.settings.grasp;
        self.elapsed_s += context.step_s;
        if percept.step_s > 0.0 {
            let mean_n = percept.fingers[..FINGERS]
                .iter()
                .map(|f| f.normal_n)
                .sum::<f64>()
                / FINGERS as f64;
            self.hardness.add(context.closing_m, mean_n, percept.step_s, &context.settings.perception);
        }
        let done = self.elapsed_s >= settings.probe_s;
        let fit = if done {
            self.hardness.fit()
        } else {
            None
        };
        // An object that turns out rock-hard must not be pressed beyond F_2 while it is still being judged.
        let (_, strongest_n) = force_range_n(percept);
        let speed_m_s = if !done && strongest_n < settings.f2_max_n {
            settings.approach_m_s
        } else {
            0.0
        };
        Proposal {
            active: true,
            closing_m_s: [speed_m_s; FINGERS],
            verdict: fit.map_or(Verdict::None, Verdict::Hardness),
            ..Proposal::default()
        }
    }
}
