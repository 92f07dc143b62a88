//! Stiffness probe (paper II.b (1)): "After the first touch during 100 msec, the robot measures the object's hardness.
//! Based on the hardness, threshold F_2 is specified."
//!
//! All fingers close at the approach speed for the probe's duration; the verdict is the fit, or, when the forces tell
//! nothing, no verdict at all: the fingers stop and the step times out rather than guess. What 100 ms of light touch
//! say of a hard object is uncertain, so the probe goes on listening: whenever the fingers press harder than ever
//! before, the fit is refined and F_2 with it. What slips tells nothing: its faces move by more than they give.

use super::{Context, Module, Proposal, Roles, Verdict, force_range_n};
use crate::perception::{Bearing, Percept, StiffnessEstimate, StiffnessFit};
use robot_model::VIRTUAL_FINGERS;
use shm_schemas::ModuleId;

/// The samples so far.
#[derive(Clone, Copy, Debug, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Probe {
    elapsed_s: f64,
    stiffness: StiffnessEstimate,
    fit: Option<StiffnessFit>,
}

impl Module for Probe {
    const ID: ModuleId = ModuleId::PROBE;
    const ROLES: Roles = Roles {
        closes_fingers: true,
        ..Roles::NONE
    };

    fn evaluate(&mut self, percept: &Percept, context: &Context<'_>) -> Proposal {
        let settings = &context.settings.grasp;
        self.elapsed_s += context.step_s;
        let done = self.elapsed_s >= settings.probe_s;
        self.listen(percept, context);
        // An object that turns out rock-hard must not be pressed beyond F_2 while it is still being judged.
        let (_, strongest_n) = force_range_n(percept);
        let pressing = !done && strongest_n < context.thresholds.most_n(settings);
        Proposal {
            active: !done,
            closing_m_s: [if pressing { settings.approach_m_s } else { 0.0 }; VIRTUAL_FINGERS],
            verdict: self
                .fit
                .filter(|_| done)
                .map_or(Verdict::None, Verdict::Stiffness),
            ..Proposal::default()
        }
    }
}

impl Probe {
    /// Takes in this tick's frame, and refines the fit if it tells something new.
    fn listen(&mut self, percept: &Percept, context: &Context<'_>) {
        let slips = percept
            .virtual_fingers
            .iter()
            .any(|finger| finger.gross_slip_s > 0.0);
        if percept.step_s <= 0.0 || slips {
            return;
        }
        let mean_n = percept
            .virtual_fingers
            .iter()
            .map(|f| f.normal_n)
            .sum::<f64>()
            / VIRTUAL_FINGERS as f64;
        let settings = &context.settings.perception;
        let news = self.stiffness.add(
            context.closing_m,
            mean_n,
            percept.step_s,
            &context.tips,
            percept.virtual_fingers.map(|finger| Bearing {
                face_share: finger.pressed_share,
                tips: finger.bearing_tips,
            }),
            settings,
        );
        self.fit = news.or(self.fit).map(|fit| StiffnessFit {
            settled: self.stiffness.has_settled(),
            ..fit
        });
    }
}
