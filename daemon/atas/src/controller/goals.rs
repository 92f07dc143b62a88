//! Goal handling: start, task execution, updates for the client, end.

use super::Controller;
use crate::executor::Outcome;
use crate::goal::{ActiveGoal, Goal};
use crate::hand::HandControl;
use robot_model::HandSide;
use shm_schemas::{
    EventKind, GoalState, GoalUpdate, GraspTarget, Hand, Mode, ModuleEvent, Reason, Stamp, Text,
};

/// Time between two progress updates without other changes, s (design choice).
const PROGRESS_S: f64 = 0.1;

impl Controller {
    /// Starts a goal, or rejects it with a reason.
    pub(super) fn start(&mut self, asked: &Goal) {
        let goal = ActiveGoal::begin(asked);
        if let Some(reason) = self.refusal(asked) {
            self.outputs.goal_update = Some(self.update_of(&goal, GoalState::REJECTED, reason));
            return;
        }
        for (hand, side) in self.hands.iter_mut().zip(HandSide::BOTH) {
            if goal.involves(side) {
                hand.start(asked, &self.settings);
            }
        }
        self.goal = Some(goal);
        self.last_goal = None;
        self.targets.set_goal(self.goal.as_ref(), self.tick);
        self.update_goal(GoalState::ACCEPTED, Reason::None);
        let hand = &self.hands[goal.side.index()];
        if let Some(runner) = hand.executor() {
            let event = hand.step_event(runner.step());
            self.outputs.events.push(event);
        }
    }

    fn refusal(&self, goal: &Goal) -> Option<Reason> {
        let mode = self.mode.mode();
        if !matches!(mode, Mode::READY | Mode::RUN) || !self.gate.is_synchronised() {
            return Some(Reason::NotReady { mode });
        }
        if let Some(goal) = &self.goal {
            let active = Some(goal.request.kind);
            return Some(Reason::Busy { active });
        }
        let demands = goal.requirements();
        let full = HandSide::BOTH.into_iter().find(|side| {
            let must_be_empty = if *side == goal.side() {
                !(demands.releases_first || demands.starts_with_object)
            } else {
                demands.both_hands
            };
            must_be_empty && self.hands[side.index()].grips()
        });
        if let Some(side) = full {
            let hand = Hand::BOTH[side.index()];
            return Some(Reason::HandFull { hand });
        }
        let acting = goal.side().index();
        let lacks = demands.starts_with_object && !self.hands[acting].grips();
        let hand = Hand::BOTH[acting];
        lacks.then_some(Reason::HandEmpty { hand })
    }

    pub(super) fn receive_targets(&mut self, targets: &[GraspTarget]) {
        let finding = self.targets.update(targets, self.tick);
        if finding.is_some() {
            self.warn(finding);
        }
        for (hand, side) in self.hands.iter_mut().zip(HandSide::BOTH) {
            hand.receive_target(self.targets.target(side));
        }
    }

    /// Ends the goal with this id; `attached_only` spares detached goals.
    pub(super) fn end_goal(&mut self, goal_id: u64, attached_only: bool, reason: Reason) {
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
            reason,
        );
    }

    /// Fails a goal that is held too long.
    pub(super) fn check_pause(&mut self) {
        let paused = self.mode.mode() == Mode::HOLD;
        let Some(goal) = self.goal.as_mut() else {
            return;
        };
        // A loop stall counts as pause. RUN only reduces the pause, so that repeated holds fail the
        // goal as well.
        let stood_s = match self.stall {
            Reason::LoopStalled { stalled_ns, .. } => stalled_ns * 1e-9,
            _ => 0.0,
        };
        goal.paused_s = if paused {
            goal.paused_s + self.step_s + stood_s
        } else {
            (goal.paused_s - self.step_s).max(0.0)
        };
        if goal.paused_s > self.settings.safety.pause_s {
            let goal = *goal;
            self.end_hands(&goal);
            self.finish(GoalState::FAILED, self.mode.reason());
        }
    }

    /// Executes every hand's task and updates the goal with the outcome.
    pub(super) fn execute_tasks(&mut self) {
        let reported = |hand: &HandControl| (hand.meeting_point(), hand.displacement_m());
        let reported = self.hands.each_ref().map(reported);
        for side in HandSide::BOTH {
            let (reached, displaced_m) = reported[1 - side.index()];
            self.hands[side.index()].receive_peer(reached, displaced_m);
            let outcome = self.hands[side.index()].run_task(
                &self.settings,
                self.step_s,
                &mut self.outputs.events,
            );
            let Some(outcome) = outcome else { continue };
            let is_goals = self.goal.is_some_and(|g| g.involves(side));
            match outcome {
                Outcome::Running => {}
                Outcome::NextStep if is_goals => self.update_goal(GoalState::RUNNING, Reason::None),
                Outcome::NextStep => {}
                Outcome::Succeeded => {
                    if !self.hands[side.index()].grips() {
                        self.hands[side.index()].abort_task();
                    }
                    if is_goals && !self.awaits_other(side) {
                        self.finish(GoalState::SUCCEEDED, Reason::None);
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
            self.update_goal(GoalState::RUNNING, Reason::None);
        }
    }

    /// Reports an unsuccessful end to the goal or the event log; the hand keeps its grip.
    fn conclude(&mut self, side: HandSide, is_goals: bool, state: GoalState, reason: Reason) {
        if let Some(goal) = self.goal.filter(|_| is_goals) {
            self.finish(state, reason);
            self.end_hands(&goal);
        } else {
            self.warn(reason);
            self.hands[side.index()].end_task(&self.settings);
        }
    }

    fn awaits_other(&self, side: HandSide) -> bool {
        let is_at_work = |own: HandSide| own != side && self.hands[own.index()].is_busy();
        let goal = self.goal.as_ref();
        goal.is_some_and(|goal| {
            HandSide::BOTH
                .into_iter()
                .any(|own| goal.involves(own) && is_at_work(own))
        })
    }

    fn end_hands(&mut self, goal: &ActiveGoal) {
        for (hand, side) in self.hands.iter_mut().zip(HandSide::BOTH) {
            if goal.involves(side) {
                hand.end_task(&self.settings);
            }
        }
    }

    /// Abandons all tasks and fails the goal, because the robot stops.
    pub(super) fn drop_goal(&mut self, reason: Reason) {
        for hand in &mut self.hands {
            hand.abort_task();
        }
        if self.goal.is_some() {
            self.finish(GoalState::FAILED, reason);
        }
    }

    fn finish(&mut self, state: GoalState, reason: Reason) {
        self.update_goal(state, reason);
        self.last_goal = self.goal.take();
        self.targets.set_goal(None, self.tick);
    }

    /// Updates and reports the goal's state.
    fn update_goal(&mut self, state: GoalState, reason: Reason) {
        let Some(mut goal) = self.goal else { return };
        if goal.state != state {
            goal.state = state;
            if state.is_final() && state != GoalState::SUCCEEDED {
                goal.reason = reason;
            }
            self.outputs.events.push(ModuleEvent {
                kind: EventKind::GOAL,
                value: f64::from(state.0),
                hand: goal.request.hand,
                reason: reason.into(),
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
            hand.executor().map_or(0.0, |r| r.progress())
        };
        GoalUpdate {
            stamp: Stamp {
                sequence: self.tick.index,
                captured_ns: self.tick.now_ns,
                writer_epoch: self.sensors.writer_epoch,
            },
            goal_id: goal.request.goal_id,
            tick: self.tick.index,
            state,
            progress: progress as f32,
            reason: reason.into(),
            step: Text::new(hand.executor().map_or("", |r| r.step().name.as_str())),
            figures: hand.figures(),
        }
    }
}
