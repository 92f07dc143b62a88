//! Action server: the protocol of ROS 2 actions over the ports of any middleware.
//!
//! Every goal is accepted, so that a refusal has a result with its cause. Results are kept for
//! [`KEPT`], so that a client that was cut off can request them again.

use std::time::{Duration, Instant};

use crate::clock::present;
use crate::middleware::{ActionPorts, Caller, Node};
use crate::wire::Action;
use crate::wire::action::{FeedbackMessage, GetResultResponse, SendGoalResponse, cancel, status};
use crate::wire::standard::{
    CancelGoalRequest, CancelGoalResponse, GoalInfo, GoalStatus, GoalStatusArray, Time, Uuid,
};

/// Time for which a result is kept: as rcl, 15 minutes.
const KEPT: Duration = Duration::from_secs(900);
/// Largest number of kept goals. Design choice: a minute of refused goals at 10 Hz.
const GOALS_MAX: usize = 600;
/// Largest number of requests of each kind per poll.
const REQUESTS_PER_POLL: usize = 32;

/// Request of a client.
#[derive(Debug)]
pub(super) enum Wanted<A: Action> {
    /// Execute a goal.
    Goal(Uuid, A::Goal),
    /// Cancel a goal.
    Cancel(Uuid),
}

struct Tracked<A: Action> {
    info: GoalInfo,
    status: i8,
    /// Clients that wait for the result.
    waiting: Vec<Caller>,
    result: Option<A::Result>,
    ended: Option<Instant>,
}

/// Server of one action.
pub(super) struct ActionServer<A: Action> {
    name: String,
    ports: Box<dyn ActionPorts<A>>,
    goals: Vec<Tracked<A>>,
}

impl<A: Action> ActionServer<A> {
    pub(super) fn new(name: &str, ports: Box<dyn ActionPorts<A>>) -> Self {
        Self {
            name: name.to_owned(),
            ports,
            goals: Vec::new(),
        }
    }

    /// Continues with the ports of another participant; all known results stay available.
    pub(super) fn reopen(&mut self, node: &mut Node) -> anyhow::Result<()> {
        self.ports = node.action(&self.name)?;
        for goal in &mut self.goals {
            goal.waiting.clear();
        }
        self.report_statuses()
    }

    /// Returns the name of the action.
    pub(super) fn name(&self) -> &str {
        &self.name
    }

    /// Answers all requests; returns those that the caller must execute.
    pub(super) fn poll(&mut self) -> Vec<Wanted<A>> {
        let mut wanted = Vec::new();
        for _ in 0..REQUESTS_PER_POLL {
            match self.poll_once(&mut wanted) {
                Ok(true) => {}
                Ok(false) => break,
                Err(error) => tracing::warn!("{}: {error:#}", self.name),
            }
        }
        self.forget();
        wanted
    }

    /// Answers at most one request of each kind; returns false if there was none.
    fn poll_once(&mut self, wanted: &mut Vec<Wanted<A>>) -> anyhow::Result<bool> {
        let mut any = false;
        if let Some((caller, request)) = self.ports.take_goal()? {
            any = true;
            let stamp = present();
            let accepted = self.accept(&request.goal_id, &stamp);
            if accepted {
                wanted.push(Wanted::Goal(request.goal_id, request.goal));
            }
            self.ports
                .respond_goal(caller, SendGoalResponse::new(accepted, stamp))?;
        }
        if let Some((caller, request)) = self.ports.take_cancel()? {
            any = true;
            let response = self.cancel(&request);
            let ids = response.goals_canceling.iter();
            wanted.extend(ids.map(|info| Wanted::Cancel(info.goal_id.clone())));
            self.ports.respond_cancel(caller, response)?;
            self.report_statuses()?;
        }
        if let Some((caller, request)) = self.ports.take_result()? {
            any = true;
            self.respond(caller, &request.goal_id)?;
        }
        Ok(any)
    }

    /// Returns true unless a goal has this id already.
    fn accept(&mut self, id: &Uuid, stamp: &Time) -> bool {
        if self.find(id).is_some() {
            tracing::warn!(
                "{}: goal rejected: its identifier was used before",
                self.name
            );
            return false;
        }
        self.goals.push(Tracked {
            info: GoalInfo {
                goal_id: id.clone(),
                stamp: stamp.clone(),
            },
            status: status::ACCEPTED,
            waiting: Vec::new(),
            result: None,
            ended: None,
        });
        true
    }

    fn find(&mut self, id: &Uuid) -> Option<&mut Tracked<A>> {
        self.goals.iter_mut().find(|goal| goal.info.goal_id == *id)
    }

    /// Selects the goals of a cancellation by identifier, by time, or all.
    fn cancel(&mut self, request: &CancelGoalRequest) -> CancelGoalResponse {
        let info = &request.goal_info;
        let (any_id, any_time) = (
            info.goal_id == Uuid::default(),
            info.stamp == Time::default(),
        );
        let time = |stamp: &Time| (stamp.sec, stamp.nanosec);
        let matches = |goal: &Tracked<A>| {
            let is_it = !any_id && goal.info.goal_id == info.goal_id;
            let is_before = !any_time && time(&goal.info.stamp) <= time(&info.stamp);
            is_it || is_before || (any_id && any_time)
        };
        let is_known = any_id
            || self
                .goals
                .iter()
                .any(|goal| goal.info.goal_id == info.goal_id);
        let mut canceling = Vec::new();
        for goal in self.goals.iter_mut().filter(|goal| matches(goal)) {
            if goal.ended.is_none() {
                goal.status = status::CANCELING;
                canceling.push(goal.info.clone());
            }
        }
        let return_code = match (is_known, any_id, canceling.is_empty()) {
            (_, _, false) => cancel::DONE,
            (false, _, true) => cancel::UNKNOWN_GOAL,
            (true, false, true) => cancel::GOAL_TERMINATED,
            (true, true, true) => cancel::REJECTED,
        };
        CancelGoalResponse {
            return_code,
            goals_canceling: canceling,
        }
    }

    /// Answers a request of a result now, or when the goal ends.
    fn respond(&mut self, caller: Caller, id: &Uuid) -> anyhow::Result<()> {
        let (status, result) = match self.find(id) {
            None => (status::UNKNOWN, A::Result::default()),
            Some(goal) => match &goal.result {
                Some(result) => (goal.status, result.clone()),
                None => {
                    goal.waiting.push(caller);
                    return Ok(());
                }
            },
        };
        self.ports
            .respond_result(caller, GetResultResponse::new(status, result))
    }

    /// Reports that a goal is being executed.
    pub(super) fn execute(&mut self, id: &Uuid) {
        if let Some(goal) = self.find(id)
            && goal.status == status::ACCEPTED
        {
            goal.status = status::EXECUTING;
        }
        self.warn_of("states", |server| server.report_statuses());
    }

    /// Publishes progress of a goal.
    pub(super) fn feedback(&mut self, id: &Uuid, feedback: A::Feedback) {
        let message = FeedbackMessage::new(id.clone(), feedback);
        self.warn_of("progress", |server| server.ports.feedback(message));
    }

    /// Ends a goal and answers the clients that wait for its result.
    pub(super) fn finish(&mut self, id: &Uuid, status: i8, result: &A::Result) {
        let Some(goal) = self.find(id) else { return };
        (goal.status, goal.result, goal.ended) =
            (status, Some(result.clone()), Some(Instant::now()));
        for caller in std::mem::take(&mut goal.waiting) {
            let response = GetResultResponse::new(status, result.clone());
            self.warn_of("a result", |server| {
                server.ports.respond_result(caller, response)
            });
        }
        self.warn_of("states", |server| server.report_statuses());
    }

    fn warn_of(&mut self, what: &str, act: impl FnOnce(&mut Self) -> anyhow::Result<()>) {
        if let Err(error) = act(self) {
            tracing::warn!("{}: {what} not sent: {error:#}", self.name);
        }
    }

    fn report_statuses(&mut self) -> anyhow::Result<()> {
        let statuses = self.goals.iter().map(|goal| GoalStatus {
            goal_info: goal.info.clone(),
            status: goal.status,
        });
        let message = GoalStatusArray {
            status_list: statuses.collect(),
        };
        self.ports.statuses(message)
    }

    /// Forgets results after their time, and the oldest ones if there are too many.
    fn forget(&mut self) {
        self.goals
            .retain(|goal| goal.ended.is_none_or(|ended| ended.elapsed() < KEPT));
        while self.goals.len() > GOALS_MAX {
            let Some(oldest) = self.goals.iter().position(|goal| goal.ended.is_some()) else {
                return;
            };
            self.goals.remove(oldest);
        }
    }
}

#[cfg(test)]
mod tests;
