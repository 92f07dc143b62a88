//! Controller: [`Controller::step`] is the whole real-time path, once per tick.

mod goals;
mod modes;

use crate::check::GoalContext;
use crate::goal::ActiveGoal;
use crate::hand::HandControl;
use crate::io::{Events, Inputs, OperatorRequest, Outputs};
use crate::joints::JointIntake;
use crate::limits::PRELOAD_MAX_RAD;
use crate::mode::ModeMachine;
use crate::safety::{Gate, GateContext, SafeCommand};
use crate::sensor_setup::SensorSetup;
use crate::settings::{PARAMETERS, Settings};
use crate::tasks::Task;
use crate::teleop::TargetIntake;
use crate::tick::{Stage, StallDetector, Tick};

use core::ops::Range;
use robot_model::{HandSide, HandVector, RobotModel, RobotVector};
use shm_schemas::capacity::HANDS;
use shm_schemas::{
    Cause, EventKind, Hand, HandStatus, JointCommand, JointStatus, Mode, ModuleEvent, Reason,
    TickReport,
};

/// Controller; only [`Controller::step`] changes its state, as a function of its inputs.
///
/// About 200 kB of plain data: keep it in a `Box`. All parts are `Copy`, so that a clone is one
/// memory copy; field by field it needs three times that size on the stack.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Controller {
    settings: Settings,
    sensors: SensorSetup,
    hands: [HandControl; HANDS],
    joints: JointIntake,
    mode: ModeMachine,
    gate: Gate,
    goal: Option<ActiveGoal>,
    last_goal: Option<ActiveGoal>,
    targets: TargetIntake,
    tick: Tick,
    stall_detector: StallDetector,
    stall: Reason,
    requested_hold: Reason,
    step_s: f64,
    /// Set by synchronisation: a hand that presses may already hold an object.
    checks_for_grip: bool,
    /// Set by a recovery: HOLD continues until gate and hands have synchronised to the robot.
    recovers: bool,
    /// Refusal of the gate in the previous tick, if it requires HOLD.
    gate_refusal: Reason,
    /// Last warning, so that a lasting cause is reported once.
    last_warning: Cause,
    outputs: Outputs,
}

impl Controller {
    /// Creates a controller for this robot. `settings` must have passed [`Settings::check`].
    #[must_use]
    pub fn new(robot: &RobotModel, wiring: SensorSetup, settings: Settings) -> Self {
        let hand =
            |side: HandSide| HandControl::new(Hand::BOTH[side.index()], *robot.hand(side), &wiring);
        Self {
            hands: [hand(HandSide::Left), hand(HandSide::Right)],
            joints: JointIntake::new(robot, wiring.joints_required),
            mode: ModeMachine::default(),
            gate: Gate::new(robot, wiring.writer_epoch),
            goal: None,
            last_goal: None,
            targets: TargetIntake::new(robot),
            tick: Tick::default(),
            stall_detector: StallDetector::new(wiring.tick_s),
            stall: Reason::None,
            requested_hold: Reason::None,
            // One period per tick: a late tick causes no jump, a missed one is not made up.
            step_s: wiring.tick_s,
            checks_for_grip: false,
            recovers: false,
            gate_refusal: Reason::None,
            last_warning: Cause::NONE,
            outputs: Outputs {
                command: JointCommand::default(),
                report: TickReport::default(),
                goal_update: None,
                events: Events::default(),
            },
            settings,
            sensors: wiring,
        }
    }

    /// Runs one tick: intake → perception → modules → arbitration → kinematics → safety.
    pub fn step(&mut self, inputs: &Inputs<'_>) -> &Outputs {
        self.step_timed(inputs, |_| {})
    }

    /// Runs [`Controller::step`] and calls `passed` after each stage, for timing by the caller.
    pub fn step_timed(
        &mut self,
        inputs: &Inputs<'_>,
        mut on_stage_end: impl FnMut(Stage),
    ) -> &Outputs {
        self.begin(inputs.tick);
        self.joints
            .update(inputs.joints, self.tick, &self.settings.intake);
        self.handle_request(inputs.request);
        self.receive_targets(inputs.targets);
        on_stage_end(Stage::Intake);
        for (hand, frames) in self.hands.iter_mut().zip(inputs.frames) {
            hand.update(frames, self.tick, &self.settings, &mut self.outputs.events);
        }
        on_stage_end(Stage::Perception);
        self.update_mode();
        if self
            .stall_detector
            .command_expired(self.settings.safety.valid_s)
        {
            self.gate.halt();
            self.hands.iter_mut().for_each(HandControl::halt);
        }
        if self.mode.mode() == Mode::RUN {
            self.execute_tasks();
        }
        on_stage_end(Stage::Modules);
        let moves = self.mode.mode() == Mode::RUN;
        let raw = core::array::from_fn(|hand| self.hands[hand].command(moves, self.step_s));
        on_stage_end(Stage::Kinematics);
        let safe = self.gate.pass(
            &raw,
            &core::array::from_fn(|hand| self.hands[hand].grip()),
            &GateContext {
                tick: self.tick,
                step_s: self.step_s,
                mode: self.mode.mode(),
                // A robot that did not track its command is the reason of many recoveries.
                measured: self
                    .joints
                    .fresh_position(self.tick, &self.settings.intake)
                    .filter(|_| !self.recovers),
                joint_sequence: self.joints.sequence(),
                grip_limit_n: core::array::from_fn(|hand| self.hands[hand].force_limit_n()),
                settings: &self.settings.safety,
            },
        );
        self.apply_gate_result(&safe);
        on_stage_end(Stage::Safety);
        self.report();
        &self.outputs
    }

    /// Returns the active settings.
    #[must_use]
    pub fn settings(&self) -> &Settings {
        &self.settings
    }

    /// Returns the context of a goal check.
    #[must_use]
    pub fn goal_context<'a>(&'a self, robot: &'a RobotModel, tasks: &'a [Task]) -> GoalContext<'a> {
        GoalContext {
            robot,
            wiring: &self.sensors,
            settings: &self.settings,
            tasks,
            commanded_position: self.gate.is_synchronised().then(|| self.gate.position()),
        }
    }

    /// Returns the sensor set-up.
    #[must_use]
    pub fn sensors(&self) -> &SensorSetup {
        &self.sensors
    }

    /// Returns the mode and its reason.
    #[must_use]
    pub fn mode(&self) -> (Mode, Reason) {
        (self.mode.mode(), self.mode.reason())
    }

    /// Returns the active goal, or the last one.
    #[must_use]
    pub fn goal(&self) -> Option<&ActiveGoal> {
        self.goal.as_ref().or(self.last_goal.as_ref())
    }

    /// Returns the name of the present step, of the goal's hand or else of a hand that keeps a grip
    /// found at start-up.
    #[must_use]
    pub fn step_name(&self) -> &str {
        let of_goal = self
            .goal()
            .and_then(|g| self.hands[g.side.index()].executor());
        let runner = of_goal.or_else(|| self.hands.iter().find_map(HandControl::executor));
        runner.map_or("", |r| r.step().name.as_str())
    }

    /// Returns counts and readings of one hand.
    #[must_use]
    pub fn hand_status(&self, side: HandSide) -> HandStatus {
        self.hands[side.index()].status(self.tick)
    }

    /// Returns the counts of the joint feedback.
    #[must_use]
    pub fn joint_status(&self) -> JointStatus {
        self.joints.status(self.tick)
    }

    fn begin(&mut self, tick: Tick) {
        self.stall = self
            .stall_detector
            .begin(tick, self.settings.safety.stall_s);
        self.tick = tick;
        self.requested_hold = Reason::None;
        self.outputs.events.begin(tick);
        self.outputs.goal_update = None;
    }

    fn handle_request(&mut self, request: Option<&OperatorRequest>) {
        match request {
            None => {}
            Some(OperatorRequest::Start(goal)) => self.start(goal),
            Some(OperatorRequest::Cancel { goal_id }) => {
                self.end_goal(*goal_id, false, Reason::Cancelled)
            }
            Some(OperatorRequest::ClientDisconnected { goal_id }) => {
                self.end_goal(*goal_id, true, Reason::ClientGone)
            }
            Some(OperatorRequest::Stop(reason)) => self.stop(*reason),
            Some(OperatorRequest::Hold(reason)) => self.requested_hold = *reason,
            Some(OperatorRequest::Recover) => self.recover(),
            Some(OperatorRequest::SetParameter { index, value }) => match PARAMETERS.get(*index) {
                Some(parameter) if parameter.is_safety() && !self.is_motion_disabled() => {
                    self.warn(Reason::NotNow);
                }
                Some(parameter) => {
                    // The supervisor checked the value; an invalid one has no effect.
                    let _unchanged = self.settings.set(parameter.name, *value);
                }
                None => {}
            },
            Some(OperatorRequest::Configure(settings)) => self.settings = *settings,
            Some(OperatorRequest::Bias { hand }) => {
                let is_ready = self.mode.mode() == Mode::READY;
                match self.hands.get_mut(*hand) {
                    Some(hand) if is_ready && !hand.is_busy() => hand.bias(),
                    _ => self.warn(Reason::NotNow),
                }
            }
        }
    }

    /// Synchronises gate and hands to the commanded joint positions; their offset from the measured
    /// ones is the grip.
    fn synchronise(&mut self, measured: &RobotVector) {
        let start = self.start_position(measured);
        self.gate.synchronise(&start);
        let ranges = self.joint_ranges();
        for (hand, range) in self.hands.iter_mut().zip(ranges) {
            hand.abort_task();
            hand.synchronise(HandVector::from_slice(&self.gate.position()[range]));
        }
        self.checks_for_grip = true;
        self.recovers = false;
    }

    /// Returns the last command, of the gate or, before its first one, as the robot reports it,
    /// some ticks late; measured positions for limbs that do not track it.
    fn start_position(&self, measured: &RobotVector) -> RobotVector {
        let remembered = self.gate.is_synchronised().then(|| self.gate.position());
        let Some(last) = remembered.or(self.joints.commanded_position()) else {
            return *measured;
        };
        let mut start = *measured;
        for (hand, range) in self.hands.iter().zip(self.joint_ranges()) {
            for limb in hand.model().limbs() {
                let follows = |own: usize| {
                    let (joint, unit) = (range.start + own, hand.model().joints()[own].radian());
                    let offset = (last[joint] - measured[joint]).abs();
                    offset <= PRELOAD_MAX_RAD * unit
                };
                if limb.clone().all(follows) {
                    let limb = range.start + limb.start..range.start + limb.end;
                    start[limb.clone()].copy_from_slice(&last[limb]);
                }
            }
        }
        start
    }

    fn joint_ranges(&self) -> [Range<usize>; HANDS] {
        let [left, right] = self
            .hands
            .each_ref()
            .map(|hand| hand.model().joints().len());
        [0..left, left..left + right]
    }

    fn apply_gate_result(&mut self, safe: &SafeCommand) {
        self.outputs.command = *safe.command();
        let ranges = self.joint_ranges();
        for (hand, range) in self.hands.iter_mut().zip(ranges) {
            hand.adopt(HandVector::from_slice(&self.gate.requested()[range]));
        }
        let finding = self.gate.refusal();
        self.gate_refusal = Reason::None;
        match finding {
            Reason::None => {}
            Reason::FollowingError { .. } => self.stop(finding),
            Reason::CommandNotFinite { .. } | Reason::CommandStep { .. } => {
                self.gate_refusal = finding;
            }
            _ if finding.cause() == self.last_warning => {}
            _ => self.warn(finding),
        }
        self.last_warning = finding.cause();
    }

    fn is_motion_disabled(&self) -> bool {
        matches!(self.mode.mode(), Mode::INIT | Mode::SAFE_STOP)
    }

    fn warn(&mut self, reason: Reason) {
        self.outputs.events.push(ModuleEvent {
            kind: EventKind::WARNING,
            reason: reason.into(),
            ..ModuleEvent::default()
        });
    }

    fn report(&mut self) {
        self.outputs.report = TickReport {
            stamp: self.outputs.command.stamp,
            tick: self.tick.index,
            goal_id: self.goal.map_or(0, |g| g.request.goal_id),
            joint_sequence: self.joints.sequence(),
            mode: self.mode.mode(),
            command_crc32: self.outputs.command.crc32,
            hands: core::array::from_fn(|hand| self.hands[hand].report(self.tick)),
            ..TickReport::default()
        };
    }
}
