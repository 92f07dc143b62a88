//! Grip state beyond the task: force limit of the held object, and holding of a found object.

use super::HandControl;
use crate::modules::force_range_n;
use crate::perception::Percept;
use crate::planning::{Waypoints, home};
use crate::runner::Runner;
use crate::safety::Grip;
use crate::settings::Settings;
use shm_schemas::{Cause, EventKind, ModuleEvent, Reason};

impl HandControl {
    /// Holds an object found in an idle hand if both sides press on it. Returns the event to
    /// publish. The robot may report F_2, N, or zero.
    pub(crate) fn keep(&mut self, told_f2_n: f64, settings: &Settings) -> Option<ModuleEvent> {
        let percept = *self.perception.percept();
        let touches = percept.virtual_fingers.iter().all(|f| f.in_contact);
        let servo = self.servo.as_mut()?;
        if !touches || self.runner.is_some() || self.borne.doubt().is_some() {
            return None;
        }
        servo.take_grip(&self.model, &percept);
        let now = *servo.frame();
        let f2_n = if self.limit_n > 0.0 {
            self.limit_n
        } else {
            told_f2_n
        };
        let waypoints = Waypoints::resting(&self.model, now, home(&self.model, &now), settings);
        self.modules.reset();
        self.arbiter.rest();
        let runner = Runner::keep(waypoints, &now, &percept, f2_n, settings);
        let (_, strongest_n) = force_range_n(&percept);
        let reason = Reason::limit(Cause::GRIP_FOUND, strongest_n, runner.thresholds().f2_n);
        self.runner = Some(runner);
        Some(ModuleEvent {
            reason: reason.about(self.hand.0 as usize),
            ..self.event(EventKind::WARNING)
        })
    }

    /// Stores F_2 of the held object until contact ends; it outlives the task.
    pub(super) fn remember_limit(&mut self) {
        let touches = |fingers: &Percept| fingers.virtual_fingers.iter().any(|f| f.in_contact);
        self.limit_n = match &self.runner {
            Some(runner) if runner.grips() => runner.thresholds().f2_n,
            _ if touches(self.perception.percept()) => self.limit_n,
            _ => 0.0,
        };
    }

    /// F_2 of the held object, N; zero for an empty hand.
    #[must_use]
    pub(crate) fn limit_n(&self) -> f64 {
        self.limit_n
    }

    /// Returns the grip state for the gate.
    #[must_use]
    pub(crate) fn grip(&self) -> Grip {
        let percept = self.perception.percept();
        Grip {
            normal_n: percept.virtual_fingers.map(|finger| finger.normal_n),
            f2_n: self
                .runner
                .as_ref()
                .filter(|r| r.stiffness().is_some())
                .map(|r| r.thresholds().f2_n),
        }
    }
}
