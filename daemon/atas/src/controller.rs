//! The controller: [`Controller::step`] is the whole real-time path, one call per tick.

use crate::goal::{ActiveGoal, Circumstances, Goal};
use crate::hand::HandControl;
use crate::io::{Events, Inputs, Order, Outputs};
use crate::joints::JointIntake;
use crate::mode::ModeMachine;
use crate::safety::{Gate, GateContext, SafeCommand};
use crate::settings::{PARAMETERS, Settings};
use crate::tasks::{Outcome, Task};
use crate::tick::StallWatch;
use crate::wiring::Wiring;
use crate::{Stage, Tick};
use robot_model::{RobotModel, Side};
use shm_schemas::capacity::HANDS;
use shm_schemas::{
    Cause, EventKind, GoalState, GoalUpdate, Hand, HandStatus, JointCommand, JointStatus, Mode,
    ModuleEvent, Reason, Stamp, Text, TickReport,
};

/// Time between two progress updates of a goal that has no other news, s (ours).
const PROGRESS_S: f64 = 0.1;

/// The pure heart: state that only [`Controller::step`] changes, and only as a function of its inputs.
#[derive(Clone, Debug)]
pub struct Controller {
    settings: Settings,
    wiring: Wiring,
    hands: [HandControl; HANDS],
    joints: JointIntake,
    mode: ModeMachine,
    gate: Gate,
    goal: Option<ActiveGoal>,
    last_goal: Option<ActiveGoal>,
    tick: Tick,
    stall_watch: StallWatch,
    stall: Reason,
    step_s: f64,
    outputs: Outputs,
}

impl Controller {
    /// A controller for this robot. `settings` must have passed [`Settings::check`].
    #[must_use]
    pub fn new(robot: &RobotModel, wiring: Wiring, settings: Settings) -> Self {
        let hand = |side: Side| {
            HandControl::new(Hand::BOTH[side.index()], robot.hand(side).clone(), &wiring)
        };
        Self {
            hands: Side::BOTH.map(hand),
            joints: JointIntake::new(robot, wiring.joints_required),
            mode: ModeMachine::default(),
            gate: Gate::new(robot, wiring.writer_epoch),
            goal: None,
            last_goal: None,
            tick: Tick::default(),
            stall_watch: StallWatch::new(wiring.tick_s),
            stall: Reason::default(),
            // Motion advances by one period per tick: a late tick does not jerk, and a missed one is not caught up.
            step_s: wiring.tick_s,
            outputs: Outputs {
                command: JointCommand::default(),
                report: TickReport::default(),
                goal_update: None,
                events: Events::default(),
            },
            settings,
            wiring,
        }
    }

    /// One tick: intake → perception → modules → arbitration → kinematics → safety.
    pub fn step(&mut self, inputs: &Inputs<'_>) -> &Outputs {
        self.step_timed(inputs, |_| {})
    }

    /// [`Controller::step`] that tells `passed` when each stage has ended, so that the caller, who has a clock, can
    /// time the stages.
    pub fn step_timed(&mut self, inputs: &Inputs<'_>, mut passed: impl FnMut(Stage)) -> &Outputs {
        self.begin(inputs.tick);
        self.joints
            .take(inputs.joints, self.tick, &self.settings.intake);
        self.obey(inputs.order);
        passed(Stage::Intake);
        for (hand, frames) in self.hands.iter_mut().zip(inputs.frames) {
            hand.feel(frames, self.tick, &self.settings, &mut self.outputs.events);
        }
        passed(Stage::Perception);
        self.update_mode();
        if self.mode.mode() == Mode::RUN {
            self.pursue();
        }
        passed(Stage::Modules);
        let moves = self.mode.mode() == Mode::RUN;
        let raw = core::array::from_fn(|hand| self.hands[hand].follow(moves, self.step_s));
        passed(Stage::Kinematics);
        let safe = self.gate.pass(
            &raw,
            &core::array::from_fn(|hand| self.hands[hand].grip()),
            &GateContext {
                tick: self.tick,
                step_s: self.step_s,
                mode: self.mode.mode(),
                measured_rad: self.joints.position_rad(),
                joint_sequence: self.joints.sequence(),
                settings: &self.settings.safety,
            },
        );
        self.settle(&safe);
        passed(Stage::Safety);
        self.report();
        &self.outputs
    }

    /// The settings in force.
    #[must_use]
    pub fn settings(&self) -> &Settings {
        &self.settings
    }

    /// What a goal is to be checked against now.
    #[must_use]
    pub fn circumstances<'a>(
        &'a self,
        robot: &'a RobotModel,
        tasks: &'a [Task],
    ) -> Circumstances<'a> {
        Circumstances {
            robot,
            wiring: &self.wiring,
            settings: &self.settings,
            tasks,
            commanded_rad: self.gate.is_anchored().then(|| self.gate.position_rad()),
        }
    }

    /// What the controller is wired to.
    #[must_use]
    pub fn wiring(&self) -> &Wiring {
        &self.wiring
    }

    /// Mode and the reason for it.
    #[must_use]
    pub fn mode(&self) -> (Mode, Reason) {
        (self.mode.mode(), self.mode.reason())
    }

    /// The active goal, or the last one.
    #[must_use]
    pub fn goal(&self) -> Option<&ActiveGoal> {
        self.goal.as_ref().or(self.last_goal.as_ref())
    }

    /// Name of the present step of the active or last goal's hand.
    #[must_use]
    pub fn step_name(&self) -> &str {
        let runner = self
            .goal()
            .and_then(|g| self.hands[g.side.index()].runner());
        runner.map_or("", |r| r.step().name.as_str())
    }

    /// Counts and readings of one hand.
    #[must_use]
    pub fn hand_status(&self, side: Side) -> HandStatus {
        self.hands[side.index()].status(self.tick)
    }

    /// Counts of the joint feedback.
    #[must_use]
    pub fn joint_status(&self) -> JointStatus {
        self.joints.status(self.tick)
    }

    fn begin(&mut self, tick: Tick) {
        self.stall = self.stall_watch.begin(tick, self.settings.safety.stall_s);
        self.tick = tick;
        self.outputs.events.begin(tick);
        self.outputs.goal_update = None;
    }

    fn obey(&mut self, order: Option<&Order>) {
        match order {
            None => {}
            Some(Order::Start(goal)) => self.start(goal),
            Some(Order::Cancel { goal_id }) => self.end_if(*goal_id, false, Cause::CANCELLED),
            Some(Order::ClientGone { goal_id }) => self.end_if(*goal_id, true, Cause::CLIENT_GONE),
            Some(Order::Stop(reason)) => self.stop(*reason),
            Some(Order::Recover) => self.recover(),
            Some(Order::SetParameter { index, value }) => {
                if let Some(parameter) = PARAMETERS.get(*index) {
                    // The supervisor checked the value; one that is wrong all the same changes nothing.
                    let _unchanged = self.settings.set(parameter.name, *value);
                }
            }
            Some(Order::Configure(settings)) => self.settings = *settings,
            Some(Order::Bias { hand }) => {
                if let Some(hand) = self.hands.get_mut(*hand) {
                    hand.bias();
                }
            }
        }
    }

    fn start(&mut self, asked: &Goal) {
        let goal = ActiveGoal::begin(asked);
        if let Some(reason) = self.refusal(asked) {
            self.outputs.goal_update = Some(self.update_of(&goal, GoalState::REJECTED, reason));
            return;
        }
        for (hand, side) in self.hands.iter_mut().zip(Side::BOTH) {
            if goal.involves(side) {
                hand.start(asked, &self.settings);
            }
        }
        self.goal = Some(goal);
        self.last_goal = None;
        self.news(GoalState::ACCEPTED, Reason::default());
        let hand = &self.hands[goal.side.index()];
        if let Some(runner) = hand.runner() {
            let event = hand.step_event(runner.step());
            self.outputs.events.push(event);
        }
    }

    fn refusal(&self, goal: &Goal) -> Option<Reason> {
        let mode = self.mode.mode();
        if !matches!(mode, Mode::READY | Mode::RUN) || !self.gate.is_anchored() {
            return Some(Reason::limit(Cause::NOT_READY, f64::from(mode.0), 0.0));
        }
        if self.goal.is_some() {
            return Some(Reason::of(Cause::BUSY));
        }
        let demands = goal.demands();
        let full = Side::BOTH.into_iter().find(|side| {
            let must_be_empty = if *side == goal.side() {
                !demands.lets_go_first
            } else {
                demands.both_hands
            };
            must_be_empty && self.hands[side.index()].grips()
        });
        full.map(|side| Reason::of(Cause::HAND_FULL).about(side.index()))
    }

    /// Ends the goal with this id; `attached_only` leaves detached goals alone.
    fn end_if(&mut self, goal_id: u64, attached_only: bool, cause: Cause) {
        let Some(goal) = self.goal.filter(|g| g.request.goal_id == goal_id) else {
            return;
        };
        if attached_only && !goal.is_attached() {
            return;
        }
        self.end_hands(&goal);
        self.finish(
            if attached_only {
                GoalState::FAILED
            } else {
                GoalState::CANCELLED
            },
            Reason::of(cause),
        );
    }

    fn stop(&mut self, reason: Reason) {
        self.mode_change(|mode| mode.stop(reason));
        self.drop_goal(reason);
    }

    fn recover(&mut self) {
        // Anywhere else anchoring would give up the grip and the task.
        if self.mode.mode() != Mode::SAFE_STOP {
            return;
        }
        self.mode_change(ModeMachine::recover);
        if let Some(measured_rad) = self.joints.position_rad().copied() {
            self.anchor(&measured_rad);
        }
    }

    fn update_mode(&mut self) {
        let fault = self.joints.fault();
        if fault.is_some() && self.gate.is_anchored() {
            self.stop(fault);
        }
        let doubts = [
            self.stall,
            self.hands[0].doubt(self.tick, &self.settings),
            self.hands[1].doubt(self.tick, &self.settings),
            self.joints.doubt(self.tick, &self.settings.intake),
        ];
        let doubt = doubts.into_iter().find(Reason::is_some).unwrap_or_default();
        let sensing_only = if self.wiring.joints_required {
            doubt
        } else {
            Reason::of(Cause::JOINTS_STOPPED)
        };
        let has_task = self.hands.iter().any(HandControl::is_busy);
        let step_s = self.step_s;
        self.mode_change(|mode| mode.update(sensing_only, has_task, step_s));
        if let Some(measured_rad) = self.joints.position_rad().copied() {
            if self.mode.mode() == Mode::READY && !self.gate.is_anchored() {
                self.anchor(&measured_rad);
            }
            for (hand, side) in self.hands.iter_mut().zip(Side::BOTH) {
                if let Some(q_rad) = self.joints.hand_rad(side) {
                    let pose = hand.model().forward(&q_rad);
                    hand.locate(&pose);
                }
            }
        }
        self.watch_pause();
    }

    /// A goal that is held for too long fails: whoever waits for it must not wait for ever.
    fn watch_pause(&mut self) {
        let paused = self.mode.mode() == Mode::HOLD;
        let Some(goal) = self.goal.as_mut() else {
            return;
        };
        goal.paused_s = if paused {
            goal.paused_s + self.step_s
        } else {
            0.0
        };
        if goal.paused_s > self.settings.safety.pause_s {
            let goal = *goal;
            self.end_hands(&goal);
            self.finish(GoalState::FAILED, self.mode.reason());
        }
    }

    fn anchor(&mut self, measured_rad: &[f64; robot_model::ROBOT_JOINTS]) {
        self.gate.anchor(measured_rad);
        for (hand, side) in self.hands.iter_mut().zip(Side::BOTH) {
            hand.abandon();
            hand.anchor(
                robot_model::HandVector::from_row_slice(&measured_rad[side.joint_range()]),
                &self.wiring,
            );
        }
    }

    /// Every hand pursues its task; the goal hears what became of it.
    fn pursue(&mut self) {
        let reached = self.hands.each_ref().map(HandControl::reached);
        for side in Side::BOTH {
            self.hands[side.index()].hear(reached[1 - side.index()]);
            let outcome =
                self.hands[side.index()].act(&self.settings, self.step_s, &mut self.outputs.events);
            let Some(outcome) = outcome else { continue };
            let is_goals = self.goal.is_some_and(|g| g.involves(side));
            match outcome {
                Outcome::Running => {}
                Outcome::NextStep if is_goals => self.news(GoalState::RUNNING, Reason::default()),
                Outcome::NextStep => {}
                Outcome::Succeeded => {
                    if !self.hands[side.index()].grips() {
                        self.hands[side.index()].abandon();
                    }
                    if is_goals && !self.awaits_other(side) {
                        self.finish(GoalState::SUCCEEDED, Reason::default());
                    }
                }
                Outcome::Refused(reason) => {
                    self.conclude(side, is_goals, GoalState::REFUSED, reason)
                }
                Outcome::Failed(reason) => self.conclude(side, is_goals, GoalState::FAILED, reason),
            }
        }
        let between = (libm::round(PROGRESS_S / self.step_s) as u64).max(1);
        let quiet = self.outputs.goal_update.is_none() && self.tick.index.is_multiple_of(between);
        if quiet && self.goal.is_some() {
            self.news(GoalState::RUNNING, Reason::default());
        }
    }

    /// A task that ended without success: the goal or the event log hears why; what the hand still holds, it keeps.
    fn conclude(&mut self, side: Side, is_goals: bool, state: GoalState, reason: Reason) {
        if let Some(goal) = self.goal.filter(|_| is_goals) {
            self.finish(state, reason);
            self.end_hands(&goal);
        } else {
            let event = ModuleEvent {
                kind: EventKind::WARNING,
                reason,
                ..ModuleEvent::default()
            };
            self.outputs.events.push(event);
        }
        self.hands[side.index()].end(&self.settings);
    }

    /// Whether the goal needs the other hand, which still works.
    fn awaits_other(&self, side: Side) -> bool {
        let is_at_work = |own: Side| own != side && self.hands[own.index()].is_busy();
        let goal = self.goal.as_ref();
        goal.is_some_and(|goal| {
            Side::BOTH
                .into_iter()
                .any(|own| goal.involves(own) && is_at_work(own))
        })
    }

    /// Every hand of a goal that ends keeps what it holds.
    fn end_hands(&mut self, goal: &ActiveGoal) {
        for (hand, side) in self.hands.iter_mut().zip(Side::BOTH) {
            if goal.involves(side) {
                hand.end(&self.settings);
            }
        }
    }

    fn settle(&mut self, safe: &SafeCommand) {
        self.outputs.command = *safe.command();
        for (hand, side) in self.hands.iter_mut().zip(Side::BOTH) {
            hand.adopt(safe.hand_rad(side));
        }
        let finding = self.gate.finding();
        match finding.cause {
            Cause::NONE => {}
            Cause::FOLLOWING_ERROR => self.stop(finding),
            _ => {
                let event = ModuleEvent {
                    kind: EventKind::WARNING,
                    reason: finding,
                    ..ModuleEvent::default()
                };
                self.outputs.events.push(event);
            }
        }
    }

    fn drop_goal(&mut self, reason: Reason) {
        for hand in &mut self.hands {
            hand.abandon();
        }
        if self.goal.is_some() {
            self.finish(GoalState::FAILED, reason);
        }
    }

    fn finish(&mut self, state: GoalState, reason: Reason) {
        self.news(state, reason);
        self.last_goal = self.goal.take();
    }

    /// Tells the client and the event log where the goal stands.
    fn news(&mut self, state: GoalState, reason: Reason) {
        let Some(mut goal) = self.goal else { return };
        if goal.state != state {
            goal.state = state;
            self.outputs.events.push(ModuleEvent {
                kind: EventKind::GOAL,
                value: f64::from(state.0),
                hand: goal.request.hand,
                reason,
                text: Text::new(state.name()),
                ..ModuleEvent::default()
            });
        }
        self.goal = Some(goal);
        self.outputs.goal_update = Some(self.update_of(&goal, state, reason));
    }

    fn update_of(&self, goal: &ActiveGoal, state: GoalState, reason: Reason) -> GoalUpdate {
        let hand = &self.hands[goal.side.index()];
        let progress = if state == GoalState::SUCCEEDED {
            1.0
        } else {
            hand.runner().map_or(0.0, |r| r.progress())
        };
        GoalUpdate {
            stamp: Stamp {
                sequence: self.tick.index,
                captured_ns: self.tick.now_ns,
                writer_epoch: self.wiring.writer_epoch,
            },
            goal_id: goal.request.goal_id,
            tick: self.tick.index,
            state,
            progress: progress as f32,
            reason,
            step: Text::new(hand.runner().map_or("", |r| r.step().name.as_str())),
            figures: hand.figures(),
        }
    }

    fn mode_change(&mut self, change: impl FnOnce(&mut ModeMachine)) {
        let before = self.mode.mode();
        change(&mut self.mode);
        let mode = self.mode.mode();
        if mode != before {
            self.outputs.events.push(ModuleEvent {
                kind: EventKind::MODE,
                mode,
                reason: self.mode.reason(),
                text: Text::new(mode.name()),
                ..ModuleEvent::default()
            });
        }
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
