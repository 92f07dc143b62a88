//! Mode handling: hold reasons, stop, recovery.

use super::Controller;
use crate::hand::HandControl;
use crate::mode::ModeMachine;
use robot_model::HandVector;
use shm_schemas::capacity::HANDS;
use shm_schemas::{EventKind, Mode, ModuleEvent, Reason, Text};

impl Controller {
    /// Stops and latches; the goal fails.
    pub(super) fn stop(&mut self, reason: Reason) {
        self.change_mode(|mode| mode.stop(reason));
        self.recovers = false;
        self.drop_goal(reason);
    }

    /// Leaves SAFE_STOP for HOLD. With fresh joint states and the robot at rest, gate and hands
    /// synchronise to it; READY follows.
    pub(super) fn recover(&mut self) {
        // In other modes a recovery would release grip and task.
        if self.mode.mode() != Mode::SAFE_STOP {
            return;
        }
        self.change_mode(ModeMachine::recover);
        self.recovers = true;
    }

    pub(super) fn update_mode(&mut self) {
        let fault = self.joints.fault();
        if fault.is_some() && self.gate.is_synchronised() {
            self.stop(fault);
        }
        if self.joints.restarted() && self.gate.is_synchronised() {
            self.handle_robot_restart();
        }
        let (hold_reason, step_s) = (self.hold_reason(), self.step_s);
        let has_task = self.hands.iter().any(HandControl::is_busy);
        self.change_mode(|mode| mode.update(hold_reason, has_task, step_s));
        self.update_poses();
        self.check_pause();
    }

    fn hold_reason(&self) -> Reason {
        let reasons = [
            self.stall,
            self.gate_refusal,
            if self.joints.restarted() {
                Reason::RobotRestarted
            } else {
                Reason::None
            },
            self.requested_hold,
            if self.recovers {
                self.mode.reason()
            } else {
                Reason::None
            },
            self.hands[0].hold_reason(self.tick, &self.settings),
            self.hands[1].hold_reason(self.tick, &self.settings),
            self.joints.hold_reason(self.tick, &self.settings.intake),
        ];
        let without_doubt = if self.sensors.joints_required {
            Reason::None
        } else {
            Reason::SenseOnly
        };
        let doubt = reasons.into_iter().find(Reason::is_some);
        doubt.unwrap_or(without_doubt)
    }

    /// Drops goal and command position: a new robot process may have any joint positions.
    fn handle_robot_restart(&mut self) {
        let reason = Reason::RobotRestarted;
        self.drop_goal(reason);
        self.gate.disarm();
    }

    /// Keeps existing grips: a hand that presses at start-up holds what an earlier daemon, or this
    /// one before a stop, gripped.
    fn keep_existing_grips(&mut self) {
        self.checks_for_grip = false;
        for hand in 0..HANDS {
            let reported_f2_n = self.joints.grip_limit_n()[hand];
            if let Some(found) = self.hands[hand].hold_found_grip(reported_f2_n, &self.settings) {
                self.outputs.events.push(found);
            }
        }
    }

    /// Updates the hands' measured poses; synchronises to a robot that is first ready, or recovers.
    fn update_poses(&mut self) {
        let Some(measured) = self.joints.position().copied() else {
            return;
        };
        let is_ready = self.mode.mode() == Mode::READY;
        if is_ready && !self.gate.is_synchronised() || self.recovers && self.can_recover() {
            self.synchronise(&measured);
        }
        if is_ready && self.checks_for_grip {
            self.keep_existing_grips();
        }
        let ranges = self.joint_ranges();
        let effort = self.joints.effort();
        for (hand, range) in self.hands.iter_mut().zip(ranges) {
            let q = HandVector::from_slice(&measured[range.clone()]);
            let effort = effort.map(|all| HandVector::from_slice(&all[range]));
            let effort = effort.as_ref();
            if hand.needs_pose() {
                let pose = hand.model().forward(&q);
                hand.update_measured(&pose, effort, &self.settings, self.step_s);
            } else {
                hand.update_resting(effort, self.step_s);
            }
        }
    }

    /// Returns true if the commanded joints rest and the measured positions are fresh.
    fn can_recover(&self) -> bool {
        let limits = &self.settings.intake;
        self.gate.is_at_rest() && self.joints.fresh_position(self.tick, limits).is_some()
    }

    fn change_mode(&mut self, change: impl FnOnce(&mut ModeMachine)) {
        let before = self.mode.mode();
        change(&mut self.mode);
        let mode = self.mode.mode();
        if mode != before {
            self.outputs.events.push(ModuleEvent {
                kind: EventKind::MODE,
                mode,
                reason: self.mode.reason().into(),
                text: Text::new(mode.name()),
                ..ModuleEvent::default()
            });
        }
    }
}
