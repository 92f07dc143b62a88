//! Panic guard around the controller: if it panics, the robot holds.
//!
//! A panic latches FAULT. From that tick on, the last command is published again with a new stamp
//! and zero velocity. The robot keeps its position and grip, and the robot driver keeps receiving
//! commands. The controller is not used until the daemon restarts, because its state may be
//! inconsistent.

use std::panic::{AssertUnwindSafe, catch_unwind};

use atas_core::goal::ActiveGoal;
use atas_core::{Controller, Inputs, Outputs, Stage, Tick};
use robot_model::HandSide;
use shm_schemas::capacity::{HANDS, JOINTS};
use shm_schemas::{
    EventKind, GoalState, GoalUpdate, HandReport, JointCommand, Mode, ModuleEvent, Reason, Stamp,
    Status, Text, TickReport,
};

/// Validity of a command after a panic in the first tick, ns. After a later one it is that of the
/// command before.
const VALID_NS: u64 = 5_000_000;

/// Outputs of a tick.
#[derive(Clone, Copy, Debug)]
pub struct Step<'a> {
    /// Command to publish.
    pub command: &'a JointCommand,
    /// Report without timings.
    pub report: &'a TickReport,
    /// Goal update.
    pub goal_update: Option<&'a GoalUpdate>,
    /// Events.
    pub events: &'a [ModuleEvent],
}

/// Controller with panic guard.
#[derive(Debug)]
pub struct PanicGuard {
    /// Boxed because it is large: moving it needs more stack than a tick.
    controller: Box<Controller>,
    last: LastOutputs,
    failure: Option<Failure>,
}

/// Values of the last good tick that a failure needs.
#[derive(Debug, Default)]
struct LastOutputs {
    command: JointCommand,
    goal_id: u64,
    events: u64,
}

#[derive(Debug)]
struct Failure {
    command: JointCommand,
    report: TickReport,
    goal_update: Option<GoalUpdate>,
    event: Option<ModuleEvent>,
}

impl PanicGuard {
    /// Wraps a controller.
    #[must_use]
    pub fn new(controller: Box<Controller>) -> Self {
        Self {
            controller,
            last: LastOutputs::default(),
            failure: None,
        }
    }

    /// Runs one tick, see [`Controller::step_timed`].
    pub fn step(&mut self, inputs: &Inputs<'_>, passed: impl FnMut(Stage)) -> Step<'_> {
        self.catch_panic(inputs, |controller| controller.step_timed(inputs, passed))
    }

    /// The controller, unless it has panicked.
    #[must_use]
    pub fn controller(&self) -> Option<&Controller> {
        self.failure.is_none().then_some(&*self.controller)
    }

    /// Returns true while a goal is active.
    #[must_use]
    pub fn has_active_goal(&self) -> bool {
        self.failure.is_none()
            && self
                .controller
                .goal()
                .is_some_and(|goal| !goal.state.is_final())
    }

    /// The controller's part of the status.
    #[must_use]
    pub fn status(&self, now_ns: u64) -> Status {
        let (mode, reason) = match self.failure {
            None => self.controller.mode(),
            Some(_) => (Mode::FAULT, Reason::ModulePanicked),
        };
        let goal = self.controller.goal();
        Status {
            stamp: Stamp {
                captured_ns: now_ns,
                ..Stamp::default()
            },
            mode,
            reason: reason.into(),
            goal_id: goal.map_or(0, |g| g.request.goal_id),
            goal_kind: goal.map_or_else(Default::default, |g| g.request.kind),
            goal_state: goal.map_or_else(Default::default, |g| self.goal_state(g.state)),
            step: Text::new(self.controller.step_name()),
            task: goal.map_or_else(Default::default, |g| g.request.task),
            goal_reason: goal.map_or_else(Default::default, |g| self.goal_reason(g).into()),
            hands: HandSide::BOTH.map(|side| self.controller.hand_status(side)),
            joints: self.controller.joint_status(),
            ..Status::default()
        }
    }

    /// A goal that was active at the panic has failed.
    fn goal_state(&self, state: GoalState) -> GoalState {
        if self.failure.is_some() && !state.is_final() {
            GoalState::FAILED
        } else {
            state
        }
    }

    fn goal_reason(&self, goal: &ActiveGoal) -> Reason {
        if self.failure.is_some() && !goal.state.is_final() {
            Reason::ModulePanicked
        } else {
            goal.reason
        }
    }

    fn catch_panic<'a>(
        &'a mut self,
        inputs: &Inputs<'_>,
        step: impl FnOnce(&'a mut Controller) -> &'a Outputs,
    ) -> Step<'a> {
        let Self {
            controller,
            last,
            failure,
        } = self;
        if failure.is_none() {
            match catch_unwind(AssertUnwindSafe(|| step(controller))) {
                Ok(outputs) => return last.record(outputs),
                Err(_) => *failure = Some(Failure::new(last, inputs.tick)),
            }
        } else if let Some(failure) = failure {
            failure.goal_update = None;
            failure.event = None;
        }
        let failure = failure.get_or_insert_with(|| Failure::new(last, inputs.tick));
        failure.hold(inputs);
        failure.step()
    }
}

impl LastOutputs {
    fn record<'a>(&mut self, outputs: &'a Outputs) -> Step<'a> {
        self.command = outputs.command;
        self.goal_id = outputs.report.goal_id;
        let events = outputs.events.as_slice();
        self.events = events
            .last()
            .map_or(self.events, |event| event.stamp.sequence + 1);
        Step {
            command: &outputs.command,
            report: &outputs.report,
            goal_update: outputs.goal_update.as_ref(),
            events,
        }
    }
}

impl Failure {
    fn new(last: &LastOutputs, tick: Tick) -> Self {
        let reason = Reason::ModulePanicked.into();
        let stamp = |sequence| Stamp {
            sequence,
            captured_ns: tick.now_ns,
            writer_epoch: last.command.stamp.writer_epoch,
        };
        let update = GoalUpdate {
            stamp: stamp(tick.index),
            goal_id: last.goal_id,
            tick: tick.index,
            state: GoalState::FAILED,
            reason,
            ..GoalUpdate::default()
        };
        let event = ModuleEvent {
            stamp: stamp(last.events),
            tick: tick.index,
            kind: EventKind::MODE,
            mode: Mode::FAULT,
            reason,
            text: Text::new(Mode::FAULT.name()),
            ..ModuleEvent::default()
        };
        Self {
            command: last.command,
            report: TickReport::default(),
            goal_update: (last.goal_id != 0).then_some(update),
            event: Some(event),
        }
    }

    /// Repeats the last command with zero velocity, this tick's stamp and the same validity.
    fn hold(&mut self, inputs: &Inputs<'_>) {
        let command = &mut self.command;
        let valid_ns = command
            .valid_until_ns
            .saturating_sub(command.stamp.captured_ns);
        let valid_ns = if valid_ns > 0 { valid_ns } else { VALID_NS };
        command.stamp.sequence += 1;
        command.stamp.captured_ns = inputs.tick.now_ns;
        command.valid_until_ns = inputs.tick.now_ns.saturating_add(valid_ns);
        command.tick = inputs.tick.index;
        command.answers_sequence = inputs
            .joints
            .map_or(command.answers_sequence, |j| j.stamp.sequence);
        command.mode = Mode::FAULT;
        command.velocity = [0.0; JOINTS];
        command.seal();
        self.report = TickReport {
            stamp: command.stamp,
            tick: inputs.tick.index,
            joint_sequence: command.answers_sequence,
            mode: Mode::FAULT,
            command_crc32: command.crc32,
            hands: [HandReport {
                frame_age_ns: u64::MAX,
                ..HandReport::default()
            }; HANDS],
            ..TickReport::default()
        };
    }

    fn step(&self) -> Step<'_> {
        Step {
            command: &self.command,
            report: &self.report,
            goal_update: self.goal_update.as_ref(),
            events: self.event.as_slice(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use atas_core::{SensorSetup, Settings};
    use robot_model::RobotModel;

    const VALID_S: f64 = 0.03;

    fn guard() -> PanicGuard {
        let robot = RobotModel::two_hand_arm().expect("the built-in robot loads");
        let mut settings = Settings::default();
        settings.safety.valid_s = VALID_S;
        PanicGuard::new(Box::new(Controller::new(
            &robot,
            SensorSetup::default(),
            settings,
        )))
    }

    fn inputs<'a>(index: u64) -> Inputs<'a> {
        Inputs {
            tick: Tick {
                index,
                now_ns: 1_000_000 * (index + 1),
            },
            ..Inputs::default()
        }
    }

    #[test]
    fn panic_holds_from_the_same_tick_on() {
        let mut guard = guard();
        let before = *guard.step(&inputs(0), |_| {}).command;
        let panicked = guard.catch_panic(&inputs(1), |_| panic!("a module"));
        assert_eq!(panicked.events.len(), 1);
        let check = |step: &Step<'_>, index: u64| {
            let command = step.command;
            assert!(command.is_intact());
            assert_eq!((command.mode, command.tick), (Mode::FAULT, index));
            assert_eq!(command.stamp.sequence, before.stamp.sequence + index);
            assert_eq!(command.stamp.writer_epoch, before.stamp.writer_epoch);
            assert_eq!(command.position, before.position);
            assert_eq!(command.velocity, [0.0; JOINTS]);
            let valid_ns = command.valid_until_ns - inputs(index).tick.now_ns;
            assert_eq!(valid_ns, (VALID_S * 1e9) as u64);
            assert_eq!(step.report.command_crc32, command.crc32);
        };
        check(&panicked, 1);
        for index in 2..5 {
            let step = guard.step(&inputs(index), |_| {});
            check(&step, index);
            assert!(step.events.is_empty() && step.goal_update.is_none());
        }
        assert_eq!(guard.status(0).mode, Mode::FAULT);
        assert!(!guard.has_active_goal());
    }
}
