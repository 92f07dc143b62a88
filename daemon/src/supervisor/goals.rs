//! Goals: taken, checked, handed to the tick, and told about until they end.

use atas_core::{Order, check};
use shm_bus::{ActiveGoal, Bus, BusError, GoalServer, now_ns};
use shm_schemas::{Cause, GoalRequest, GoalState, GoalUpdate, Reason, Stamp, Text};

use super::SupervisorState;
use crate::link::SupervisorEnd;

/// New goals that one round looks at; a flood waits in its clients' buffers. Each check takes some 2 ms.
const GOALS_PER_ROUND: usize = 8;
/// Goals that are open at a time, queued ones included.
const OPEN_MAX: usize = 16;

/// The goals that clients wait for.
#[derive(Debug)]
pub(super) struct GoalService {
    server: GoalServer,
    open: Vec<OpenGoal>,
}

#[derive(Debug)]
struct OpenGoal {
    id: u64,
    client: ActiveGoal,
    cancelled: bool,
    ended: bool,
}

impl GoalService {
    pub(super) fn open(bus: &Bus) -> Result<Self, BusError> {
        Ok(Self {
            server: bus.goal_server()?,
            open: Vec::with_capacity(OPEN_MAX),
        })
    }

    /// Takes new goals, passes on cancels, notices clients that went away.
    pub(super) fn serve(&mut self, state: &SupervisorState, link: &mut SupervisorEnd) {
        for _ in 0..GOALS_PER_ROUND {
            match self.server.poll() {
                Ok(Some(client)) => self.receive(client, state, link),
                Ok(None) => break,
                Err(error) => {
                    tracing::warn!(%error, "a goal could not be read");
                    break;
                }
            }
        }
        self.open.retain_mut(|goal| goal.attend(link));
    }

    /// Passes on news; the final one closes the goal.
    pub(super) fn tell(&mut self, update: &GoalUpdate) {
        if let Some(goal) = self.open.iter_mut().find(|goal| goal.id == update.goal_id) {
            // A client that is gone is noticed in `attend`.
            let _heard = goal.client.update(update);
            goal.ended = update.state.is_final();
        }
        self.open.retain(|goal| !goal.ended);
    }

    fn receive(&mut self, client: ActiveGoal, state: &SupervisorState, link: &mut SupervisorEnd) {
        // The client can write to this memory: what is checked must be what is used.
        let request = *client.request();
        match self.admit(&request, state, link) {
            Ok(()) => {
                self.open.push(OpenGoal {
                    id: request.goal_id,
                    client,
                    cancelled: false,
                    ended: false,
                });
            }
            Err(reason) => {
                let task = &request.task;
                tracing::info!(goal = request.goal_id, kind = %request.kind, %task, %reason, "goal rejected");
                let _heard = client.update(&rejection(&request, reason, state.tick));
            }
        }
    }

    fn admit(
        &self,
        request: &GoalRequest,
        state: &SupervisorState,
        link: &mut SupervisorEnd,
    ) -> Result<(), Reason> {
        let goal = check::check(request, &state.circumstances())?;
        let id_in_use = self.open.iter().any(|goal| goal.id == request.goal_id);
        if id_in_use || self.open.len() >= OPEN_MAX {
            return Err(Reason::of(Cause::BUSY));
        }
        let queued = link.order(Order::Start(goal));
        queued.map(|_ticket| ()).ok_or(Reason::of(Cause::BUSY))
    }
}

impl OpenGoal {
    /// Passes on what the client did; `false` if it went away. What finds no room is tried again in the next round.
    fn attend(&mut self, link: &mut SupervisorEnd) -> bool {
        let goal_id = self.id;
        if !self.client.client_alive() {
            return link.order(Order::ClientGone { goal_id }).is_none();
        }
        if !self.cancelled && self.client.cancel_requested() {
            self.cancelled = link.order(Order::Cancel { goal_id }).is_some();
        }
        true
    }
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
        reason,
        step: match reason.cause {
            Cause::UNKNOWN_TASK => Text::new(request.task.as_str()),
            _ => Text::default(),
        },
        ..GoalUpdate::default()
    }
}
