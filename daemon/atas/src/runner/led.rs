//! What the runner does for a hand that a client leads.

use super::{MEET_M, Runner};
use crate::follow::Lead;
use crate::modules::Modules;
use crate::path::Path;
use crate::perception::Percept;
use crate::settings::Settings;
use crate::tasks::{Motion, Transition};
use robot_model::GraspFrame;
use shm_schemas::{GripOrder, ModuleId};

/// Opening beyond the one at which an object was touched that means letting go of it, m (ours: more than a policy's widths
/// scatter).
const WIDER_M: f64 = 0.002;
/// Opening below the present one that means closing, m (ours: what the fingers lag behind while they stand).
const CLOSING_M: f64 = 0.0002;
/// Half opening below which nothing can be between the fingertips, m (ours: the search ends there).
const EMPTY_M: f64 = 0.0025;
/// Drop of the target below the hand that means setting down, m (ours).
const DOWN_M: f64 = 0.0002;

impl Runner {
    /// Takes in what the client that leads the hand wants; `None` while it is silent.
    pub fn receive_lead(&mut self, lead: Option<Lead>) {
        self.lead = lead;
        if let Some(lead) = lead {
            // Modules may ask where the way leads.
            self.path = Path::stay(lead.frame);
        }
    }

    /// Whether a client leads this hand, or has led it until now.
    #[must_use]
    pub fn is_led(&self) -> bool {
        self.step().modules.contains(ModuleId::FOLLOW)
    }

    /// Whether the client wants something held, or its fingers have met something while closing.
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

    /// Whether the client wants the hand wider than what it holds, or is about to hold.
    pub(super) fn wants_opening(&self) -> bool {
        let holds = self.is_led()
            && self.step().transition != Transition::GripWanted
            && self.step().transition != Transition::Held;
        let wider = |lead: &Lead| {
            lead.grip == GripOrder::WIDTH && lead.opening_m() > self.touched_opening_m + WIDER_M
        };
        holds && self.lead.as_ref().is_some_and(wider)
    }

    /// Whether the fingers of a led hand have met without anything between them.
    pub(super) fn found_nothing(&self, now: &GraspFrame) -> bool {
        let searches = self.is_led() && self.step().transition == Transition::AllTouched;
        searches && now.half_opening_m.iter().any(|half_m| *half_m < MEET_M)
    }

    /// Lets go: the client's widths count again.
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

    /// How far the client leads the hand down, m; `None` if it does not.
    pub(super) fn led_down_m(&self, now: &GraspFrame) -> Option<f64> {
        let lead = self.lead.as_ref()?;
        let down_m = now.centre_m.z - lead.frame.centre_m.z;
        (self.step().motion == Motion::Follow && down_m > DOWN_M).then_some(down_m)
    }
}
