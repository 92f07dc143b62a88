//! Executor functions of a teleoperated hand.

use super::{MEET_M, Runner};
use crate::follow::Lead;
use crate::modules::Modules;
use crate::path::Path;
use crate::perception::Percept;
use crate::settings::Settings;
use crate::tasks::{Motion, Transition};
use robot_model::GraspFrame;
use shm_schemas::{GripOrder, ModuleId};

/// Opening beyond the first-contact opening that requests a release, m (design choice: exceeds the
/// scatter of policy widths).
const WIDER_M: f64 = 0.002;
/// Opening below the current one that requests closing, m (design choice: exceeds the finger lag at
/// rest).
const CLOSING_M: f64 = 0.0002;
/// Half opening below which the hand is empty, m (design choice: the search ends there).
const EMPTY_M: f64 = 0.0025;
/// Target depth below the hand that requests lowering, m (design choice).
const DOWN_M: f64 = 0.0002;

impl Runner {
    /// Sets the client's target; `None` while the client sends none.
    pub fn receive_lead(&mut self, lead: Option<Lead>) {
        self.lead = lead;
        if let Some(lead) = lead {
            // Modules may use the path direction.
            self.path = Path::stay(lead.frame);
        }
    }

    /// Returns true if the present step is teleoperated, even if the client stopped sending.
    #[must_use]
    pub fn is_led(&self) -> bool {
        self.step().modules.contains(ModuleId::FOLLOW)
    }

    /// Returns true if the client requests a grip, or the fingers touch something while closing.
    pub(super) fn wants_grip(&self, percept: &Percept, now: &GraspFrame) -> bool {
        let Some(lead) = &self.lead else {
            return false;
        };
        let open_m = now.half_opening_m.iter().sum::<f64>();
        if lead.grip == GripOrder::HOLD {
            return now.half_opening_m.iter().all(|half_m| *half_m > EMPTY_M);
        }
        let touches = percept.virtual_fingers.iter().any(|f| f.in_contact);
        touches && lead.opening_m() < open_m - CLOSING_M
    }

    /// Returns true if the client requests an opening wider than the object.
    pub(super) fn wants_opening(&self) -> bool {
        let holds = self.is_led()
            && self.step().transition != Transition::GripWanted
            && self.step().transition != Transition::Held;
        let wider = |lead: &Lead| {
            lead.grip == GripOrder::WIDTH && lead.opening_m() > self.touched_opening_m + WIDER_M
        };
        holds && self.lead.as_ref().is_some_and(wider)
    }

    /// Returns true if the fingertips of a teleoperated hand met without an object between them.
    pub(super) fn found_nothing(&self, now: &GraspFrame) -> bool {
        let searches = self.is_led() && self.step().transition == Transition::AllTouched;
        searches && now.half_opening_m.iter().any(|half_m| *half_m < MEET_M)
    }

    /// Releases the object and follows the client's opening again.
    pub(super) fn begin_again(
        &mut self,
        now: &GraspFrame,
        settings: &Settings,
        modules: &mut Modules,
    ) {
        modules.let_go();
        let lead = self.lead;
        let (track, waypoints, wishes) = (self.track, self.waypoints, self.wishes);
        *self = Self::start(track, waypoints, now, wishes, settings);
        self.receive_lead(lead);
    }

    /// Returns how far the target is below the hand, m, if the client requests lowering.
    pub(super) fn led_down_m(&self, now: &GraspFrame) -> Option<f64> {
        let lead = self.lead.as_ref()?;
        let down_m = now.centre_m.z - lead.frame.centre_m.z;
        (self.step().motion == Motion::Follow && down_m > DOWN_M).then_some(down_m)
    }
}
