//! Stiffness probe (paper II.b (1)): "After the first touch during 100 msec, the robot measures the
//! object's hardness. Based on the hardness, threshold F_2 is specified."
//!
//! Both sides close at the approach speed. The verdict is the fit. Without usable forces there is
//! none, so the fingers stop and the step times out. For a hard object the estimate is uncertain
//! after 100 ms of light touch. Every later force maximum therefore refines the fit and F_2. Frames
//! with slip are ignored: faces then move by more than their compression.

use super::{Context, Module, Proposal, Roles, Verdict};
use crate::perception::{LoadedArea, Percept, StiffnessEstimate, StiffnessFit};
use robot_model::PerSide;
use shm_schemas::ModuleId;

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
        self.update(percept, context);
        // Rigid objects must not be pressed beyond F_2 during the probe.
        let (_, strongest_n) = percept.normal_range_n();
        let pressing = !done && strongest_n < context.object.thresholds.force_ceiling_n(settings);
        Proposal {
            active: !done,
            closing_m_s: PerSide::repeat(if pressing { settings.approach_m_s } else { 0.0 }),
            verdict: self
                .fit
                .filter(|_| done)
                .map_or(Verdict::None, Verdict::Stiffness),
            ..Proposal::default()
        }
    }
}

impl Probe {
    /// Adds this tick's frame.
    fn update(&mut self, percept: &Percept, context: &Context<'_>) {
        let slips = percept.sides.iter().any(|finger| finger.gross_slip_s > 0.0);
        if percept.step_s <= 0.0 || slips {
            return;
        }
        let mean_n = percept.mean_normal_n();
        let settings = &context.settings.perception;
        let news = self.stiffness.add(
            context.object.closing_m,
            mean_n,
            percept.step_s,
            &context.hand.compression,
            percept.sides.map(|finger| LoadedArea {
                face_share: finger.loaded_share,
                fingertips: finger.loaded_fingertips,
            }),
            settings,
        );
        self.fit = news.or(self.fit).map(|fit| StiffnessFit {
            new_contact: self.stiffness.has_new_contact(),
            ..fit
        });
    }
}
