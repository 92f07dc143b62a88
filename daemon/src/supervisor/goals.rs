//! Goals: received, checked, passed to the tick, and reported until they end.

use atas_core::OperatorRequest;
use robot_model::RobotVector;
use shm_bus::{ActiveGoal, Bus, GoalServer, now_ns};
use shm_schemas::{GoalKind, GoalRequest, GoalState, GoalUpdate, Reason, Stamp, Text};

use super::checker::{CheckResult, Checker};
use super::{OpenError, SupervisorState};
use crate::link::SupervisorSide;

/// Maximum joint motion during a check for which its result still holds, rad: less than half a
/// millimetre at the hand. Design choice.
const JOINT_MOTION_MAX_RAD: f64 = 0.001;
/// Maximum number of checks of one goal while the arms move, then it is rejected as busy. Design
/// choice: 0.1 s of rounds.
const CHECKS_MAX: u32 = 25;
/// Maximum number of open goals, queued ones included.
const OPEN_MAX: usize = 16;

#[derive(Debug)]
pub(super) struct GoalService {
    server: GoalServer,
    checker: Checker,
    /// Goal under check; others wait in their clients' buffers.
    candidate: Option<Candidate>,
    open: Vec<OpenGoal>,
}

#[derive(Debug)]
struct Candidate {
    client: ActiveGoal,
    checks: u32,
}

#[derive(Debug)]
struct OpenGoal {
    id: u64,
    kind: GoalKind,
    client: ActiveGoal,
    cancelled: bool,
    ended: bool,
}

impl GoalService {
    pub(super) fn open(bus: &Bus, state: &SupervisorState) -> Result<Self, OpenError> {
        Ok(Self {
            server: bus.goal_server()?,
            checker: Checker::start(state)?,
            candidate: None,
            open: Vec::with_capacity(OPEN_MAX),
        })
    }

    /// Receives new goals, forwards cancellations, detects clients that have gone.
    pub(super) fn serve(&mut self, state: &SupervisorState, link: &mut SupervisorSide) {
        if let Some(candidate) = self.candidate.take() {
            match self.checker.poll() {
                Some(checked) => self.finish_check(candidate, checked, state, link),
                None => self.candidate = Some(candidate),
            }
        }
        if self.candidate.is_none() {
            let busy = self.busy_reason();
            match self.server.poll() {
                // No check could make the goal executable, and its first finding would hide the
                // cause.
                Ok(Some(client)) if !state.sensor_setup.joints_required => {
                    reject(&client, Reason::SenseOnly, state);
                }
                Ok(Some(client)) => match busy {
                    Some(reason) => reject(&client, reason, state),
                    None => self.check(Candidate { client, checks: 0 }, state),
                },
                Ok(None) => {}
                Err(error) => tracing::warn!(%error, "could not read a goal"),
            }
        }
        self.open.retain_mut(|goal| goal.forward_client(link));
    }

    /// Forwards an update; the final one closes the goal.
    pub(super) fn forward_update(&mut self, update: &GoalUpdate) {
        if let Some(goal) = self.open.iter_mut().find(|goal| goal.id == update.goal_id) {
            // `forward_client` detects a client that has gone.
            let _heard = goal.client.update(update);
            goal.ended = update.state.is_final();
        }
        self.open.retain(|goal| !goal.ended);
    }

    /// Reason why no other goal can start. While the arms move, a check of paths from their present
    /// position would not hold.
    fn busy_reason(&self) -> Option<Reason> {
        let goes_on = self.open.iter().find(|goal| !goal.cancelled);
        goes_on.map(|goal| Reason::Busy {
            active: Some(goal.kind),
        })
    }

    fn check(&mut self, candidate: Candidate, state: &SupervisorState) {
        // The client can write to this memory: check and use the same copy.
        self.checker.start_check(*candidate.client.request(), state);
        self.candidate = Some(Candidate {
            checks: candidate.checks + 1,
            ..candidate
        });
    }

    /// Passes a checked goal to the tick, or rejects it.
    fn finish_check(
        &mut self,
        candidate: Candidate,
        checked: CheckResult,
        state: &SupervisorState,
        link: &mut SupervisorSide,
    ) {
        let moved = have_moved(&checked.commanded_position, &state.commanded_position);
        if moved && candidate.checks < CHECKS_MAX {
            return self.check(candidate, state);
        }
        let (request, client) = (checked.request, candidate.client);
        let goal = checked.goal.and_then(|goal| {
            let busy = Reason::Busy { active: None };
            let id_in_use = self.open.iter().any(|goal| goal.id == request.goal_id);
            if moved || id_in_use || self.open.len() >= OPEN_MAX {
                return Err(busy);
            }
            let queued = link.request(OperatorRequest::Start(goal));
            queued.map(|_ticket| ()).ok_or(busy)
        });
        match goal {
            Ok(()) => self.open.push(OpenGoal {
                id: request.goal_id,
                kind: request.kind,
                client,
                cancelled: false,
                ended: false,
            }),
            Err(reason) => reject(&client, reason, state),
        }
    }
}

/// Returns true if the arms have moved too far for a check to hold.
fn have_moved(before: &Option<RobotVector>, now: &Option<RobotVector>) -> bool {
    match (before, now) {
        (Some(before), Some(now)) => {
            let mut joints = before.iter().zip(now.iter());
            joints.any(|(before, now)| (before - now).abs() > JOINT_MOTION_MAX_RAD)
        }
        (None, None) => false,
        _ => true,
    }
}

impl OpenGoal {
    /// Forwards the client's cancellation or end; returns false if the client has gone. Retries
    /// next round if the queue is full.
    fn forward_client(&mut self, link: &mut SupervisorSide) -> bool {
        let goal_id = self.id;
        if !self.client.client_alive() {
            return link
                .request(OperatorRequest::ClientDisconnected { goal_id })
                .is_none();
        }
        if !self.cancelled && self.client.cancel_requested() {
            self.cancelled = link.request(OperatorRequest::Cancel { goal_id }).is_some();
        }
        true
    }
}

fn reject(client: &ActiveGoal, reason: Reason, state: &SupervisorState) {
    let request = *client.request();
    let task = &request.task;
    tracing::info!(goal = request.goal_id, kind = %request.kind, %task, %reason, "goal rejected");
    // A client that has gone needs no answer.
    let _heard = client.update(&rejection(&request, reason, state.tick));
}

fn rejection(request: &GoalRequest, reason: Reason, tick: u64) -> GoalUpdate {
    GoalUpdate {
        stamp: Stamp {
            captured_ns: now_ns(),
            ..Stamp::default()
        },
        goal_id: request.goal_id,
        tick,
        state: GoalState::REJECTED,
        reason: reason.into(),
        step: match reason {
            Reason::UnknownTask => Text::new(request.task.as_str()),
            _ => Text::default(),
        },
        ..GoalUpdate::default()
    }
}
