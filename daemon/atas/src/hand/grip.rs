//! Grip state beyond the task: force limit of the held object, and holding of a found object.

use super::HandControl;
use super::torque_force_check::TorqueForceCheck;
use crate::executor::TaskExecutor;
use crate::perception::Percept;
use crate::planning::{Waypoints, home_pose};
use crate::safety::Grip;
use crate::settings::Settings;
use robot_model::HandVector;
use shm_schemas::{EventKind, ModuleEvent, Reason};

impl HandControl {
    /// Holds an object found in an idle hand if both sides press on it. Returns the event to
    /// publish. The robot may report F_2, N, or zero.
    pub(crate) fn hold_found_grip(
        &mut self,
        reported_f2_n: f64,
        settings: &Settings,
    ) -> Option<ModuleEvent> {
        let percept = *self.perception.percept();
        let touches = percept.sides.iter().all(|f| f.in_contact);
        let servo = self.servo.as_mut()?;
        if !touches || self.executor.is_some() || self.torque_check.mismatch().is_some() {
            return None;
        }
        servo.initialise_grip(&self.model, &percept);
        let now = *servo.pose();
        let f2_n = if self.force_limit_n > 0.0 {
            self.force_limit_n
        } else {
            reported_f2_n
        };
        let waypoints =
            Waypoints::resting(&self.model, now, home_pose(&self.model, &now), settings);
        self.modules.reset();
        self.arbiter.reset();
        let runner = TaskExecutor::hold_found(waypoints, &now, &percept, f2_n, settings);
        let (_, strongest_n) = percept.normal_range_n();
        let reason = Reason::GripFound {
            hand: self.hand,
            force_n: strongest_n,
            limit_n: runner.object().thresholds().f2_n,
        };
        self.executor = Some(runner);
        Some(ModuleEvent {
            reason: reason.into(),
            ..self.event(EventKind::WARNING)
        })
    }

    /// Stores F_2 of the held object until contact ends; it outlives the task.
    pub(super) fn update_force_limit(&mut self) {
        let touches = |fingers: &Percept| fingers.sides.iter().any(|f| f.in_contact);
        self.force_limit_n = match &self.executor {
            Some(runner) if runner.grips() => runner.object().thresholds().f2_n,
            _ if touches(self.perception.percept()) => self.force_limit_n,
            _ => 0.0,
        };
    }

    /// Returns false for an idle hand without contact; nothing uses its measured pose.
    #[must_use]
    pub(crate) fn needs_pose(&self) -> bool {
        self.is_busy()
            || self
                .perception
                .percept()
                .sides
                .iter()
                .any(|side| side.in_contact)
    }

    /// Processes the servo torques, N·m or N, of a hand that does not need its measured pose.
    pub(crate) fn update_resting(&mut self, effort: Option<&HandVector>, step_s: f64) {
        match effort {
            Some(effort) => self.torque_check.learn_free(effort, step_s),
            None => self.torque_check = TorqueForceCheck::new(&self.model),
        }
    }

    /// F_2 of the held object, N; zero for an empty hand.
    #[must_use]
    pub(crate) fn force_limit_n(&self) -> f64 {
        self.force_limit_n
    }

    /// Returns the grip state for the gate.
    #[must_use]
    pub(crate) fn grip(&self) -> Grip {
        let percept = self.perception.percept();
        Grip {
            normal_n: percept.sides.map(|finger| finger.normal_n),
            f2_n: self
                .executor
                .as_ref()
                .filter(|r| r.object().stiffness().is_some())
                .map(|r| r.object().thresholds().f2_n),
        }
    }
}
