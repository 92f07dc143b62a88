//! Executor functions of a teleoperated hand.

use super::TaskExecutor;
use super::transitions::FINGERTIPS_MEET_M;
use crate::modules::Modules;
use crate::path::Path;
use crate::perception::Percept;
use crate::settings::Settings;
use crate::tasks::{Motion, Transition};
use crate::teleop::TeleopTarget;
use robot_model::GraspPose;
use shm_schemas::{GripOrder, ModuleId};

/// Opening beyond the first-contact opening that requests a release, m (design choice: exceeds the
/// scatter of policy widths).
const RELEASE_WIDER_M: f64 = 0.002;
/// Opening below the current one that requests closing, m (design choice: exceeds the finger lag at
/// rest).
const CLOSING_M: f64 = 0.0002;
/// Half opening below which the hand is empty, m (design choice: the search ends there).
const EMPTY_HALF_OPENING_M: f64 = 0.0025;
/// Target depth below the hand that requests lowering, m (design choice).
const LOWERING_M: f64 = 0.0002;

/// Teleoperation of the hand.
#[derive(Clone, Copy, Debug, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Teleoperation {
    /// Target of the client; `None` while it sends none.
    pub(super) target: Option<TeleopTarget>,
    /// Opening at the start of a grip, later at the touch of all sides, m.
    pub(super) touched_opening_m: f64,
}

impl TaskExecutor {
    /// Sets the client's target; `None` while the client sends none.
    pub fn receive_target(&mut self, lead: Option<TeleopTarget>) {
        self.teleoperation.target = lead;
        if let Some(lead) = lead {
            // Modules may use the path direction.
            self.path = Path::stationary(lead.pose);
        }
    }

    /// Returns true if the present step is teleoperated, even if the client stopped sending.
    #[must_use]
    pub fn is_teleoperated(&self) -> bool {
        self.step().modules.contains(ModuleId::TELEOP)
    }

    /// Returns true if the client requests a grip, or the fingers touch something while closing.
    pub(super) fn grip_requested(&self, percept: &Percept, now: &GraspPose) -> bool {
        let Some(lead) = &self.teleoperation.target else {
            return false;
        };
        let open_m = now.half_opening_m.iter().sum::<f64>();
        if lead.grip == GripOrder::HOLD {
            return now
                .half_opening_m
                .iter()
                .all(|half_m| *half_m > EMPTY_HALF_OPENING_M);
        }
        let touches = percept.sides.iter().any(|f| f.in_contact);
        touches && lead.opening_m() < open_m - CLOSING_M
    }

    /// Returns true if the client requests an opening wider than the object.
    pub(super) fn opening_requested(&self) -> bool {
        let holds = self.is_teleoperated()
            && self.step().transition != Transition::GripRequested
            && self.step().transition != Transition::Held;
        let wider = |lead: &TeleopTarget| {
            lead.grip == GripOrder::WIDTH
                && lead.opening_m() > self.teleoperation.touched_opening_m + RELEASE_WIDER_M
        };
        holds && self.teleoperation.target.as_ref().is_some_and(wider)
    }

    /// Returns true if the fingertips of a teleoperated hand met without an object between them.
    pub(super) fn fingertips_met(&self, now: &GraspPose) -> bool {
        self.is_teleoperated()
            && self.searches()
            && now
                .half_opening_m
                .iter()
                .any(|half_m| *half_m < FINGERTIPS_MEET_M)
    }

    /// Releases the object and follows the client's opening again.
    pub(super) fn restart_teleop(
        &mut self,
        now: &GraspPose,
        settings: &Settings,
        modules: &mut Modules,
    ) {
        modules.release_object();
        let lead = self.teleoperation.target;
        let (track, waypoints, wishes) = (self.sequence, self.waypoints, self.parameters);
        *self = Self::start(track, waypoints, now, wishes, settings);
        self.receive_target(lead);
    }

    /// Returns how far the target is below the hand, m, if the client requests lowering.
    pub(super) fn target_below_m(&self, now: &GraspPose) -> Option<f64> {
        let lead = self.teleoperation.target.as_ref()?;
        let down_m = now.centre_m.z - lead.pose.centre_m.z;
        (self.step().motion == Motion::Teleop && down_m > LOWERING_M).then_some(down_m)
    }
}
