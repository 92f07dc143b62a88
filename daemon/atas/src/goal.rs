//! Goals: what is asked, and what of it is being pursued.
//!
//! A [`GoalRequest`] is whatever a client sent. A [`Goal`] has a known hand, policy and turn, and its task with it: it can
//! be started whatever becomes of the configuration, and recorded as it was.

use crate::tasks::{self, Demands, Task};
use robot_model::Side;
use shm_schemas::{Cause, GoalKind, GoalPolicy, GoalRequest, GoalState, Reason};

/// A goal that can be started.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Goal {
    request: GoalRequest,
    side: Side,
    task: Task,
    demands: Demands,
    spare_m: f64,
}

impl Goal {
    /// Looks up the codes of a request, and its task among the built-in ones or, for [`GoalKind::CUSTOM`], by
    /// its name: among the user's own, then among the built-in ones. Says nothing about numbers and reach: that is [`crate::check`]'s.
    ///
    /// # Errors
    /// The [`Reason`] for the refusal.
    pub fn resolve(request: &GoalRequest, own: &[Task]) -> Result<Self, Reason> {
        let unknown = |index: usize, code: u32| {
            Reason::limit(Cause::UNKNOWN_GOAL, f64::from(code), 0.0).about(index)
        };
        let task = match request.kind {
            GoalKind::CUSTOM => own
                .iter()
                .find(|task| task.name == request.task.as_str())
                .or_else(|| tasks::named(request.task.as_str()))
                .ok_or(Reason::of(Cause::UNKNOWN_TASK))?,
            kind => tasks::of(kind).ok_or(unknown(0, kind.0))?,
        };
        if !request.policy.is_known() {
            return Err(unknown(2, request.policy.0));
        }
        if !request.turn.is_known() {
            return Err(unknown(3, request.turn.0));
        }
        let hand = request.hand.index().ok_or(unknown(1, request.hand.0))?;
        Ok(Self::of(*request, Side::BOTH[hand], *task))
    }

    pub(crate) fn of(request: GoalRequest, side: Side, task: Task) -> Self {
        Self {
            request,
            side,
            demands: task.demands(),
            task,
            spare_m: 0.0,
        }
    }

    /// The same, with how far its ways were found to be from what is beside them, m.
    #[must_use]
    pub(crate) fn with_spare(self, spare_m: f64) -> Self {
        Self { spare_m, ..self }
    }

    /// How far each hand may grasp beside where it was told, m: as far as the arms then keep their distance. Zero until the ways
    /// were checked.
    #[must_use]
    pub fn spare_m(&self) -> f64 {
        self.spare_m
    }

    /// What the client asked.
    #[must_use]
    pub fn request(&self) -> &GoalRequest {
        &self.request
    }

    /// Which hand acts.
    #[must_use]
    pub fn side(&self) -> Side {
        self.side
    }

    /// What the hands do.
    #[must_use]
    pub fn task(&self) -> &Task {
        &self.task
    }

    /// What the task asks of the goal.
    #[must_use]
    pub fn demands(&self) -> Demands {
        self.demands
    }

    /// Where the object stands afterwards, m, and the direction of the closing axis there, rad.
    #[must_use]
    pub fn destination(&self) -> ([f64; 3], f64) {
        let request = &self.request;
        if self.demands.visits_target {
            (request.to_m, request.to_yaw_rad)
        } else {
            (request.from_m, request.from_yaw_rad)
        }
    }

    /// Height of the grasp while the object is carried, m: `lift_m` over the higher of its places.
    #[must_use]
    pub fn travel_height_m(&self) -> f64 {
        let ([.., to_m], _) = self.destination();
        let [.., from_m] = self.request.from_m;
        let highest_m = if to_m > from_m { to_m } else { from_m };
        highest_m + self.request.lift_m
    }
}

/// The goal that is being pursued.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct ActiveGoal {
    /// What was asked.
    pub request: GoalRequest,
    /// Which hand acts.
    pub side: Side,
    /// Whether the other hand takes part.
    pub both_hands: bool,
    /// Where it stands.
    pub state: GoalState,
    /// Why, if it ended without success.
    pub reason: Reason,
    /// How long it has been paused in HOLD, s.
    pub paused_s: f64,
}

impl ActiveGoal {
    /// A goal that begins.
    #[must_use]
    pub fn begin(goal: &Goal) -> Self {
        Self {
            request: goal.request,
            side: goal.side,
            both_hands: goal.demands.both_hands,
            state: GoalState::ACCEPTED,
            reason: Reason::default(),
            paused_s: 0.0,
        }
    }

    /// Whether this hand takes part.
    #[must_use]
    pub fn involves(&self, side: Side) -> bool {
        side == self.side || self.both_hands
    }

    /// Whether the goal ends when its client goes away. Nobody else can lead a hand that a client leads.
    #[must_use]
    pub fn is_attached(&self) -> bool {
        self.request.policy == GoalPolicy::ATTACHED || self.request.kind.is_stream()
    }
}
