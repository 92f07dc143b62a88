//! Goals: resolution of requests, and state of the active goal.
//!
//! A [`GoalRequest`] is unchecked. A [`Goal`] has a valid hand, policy and turn, and a copy of its
//! task, so that configuration changes do not affect it and it can be recorded.

use crate::tasks::{self, Task, TaskRequirements};
use robot_model::HandSide;
use shm_schemas::{GoalKind, GoalPolicy, GoalRequest, GoalState, Reason};

/// Goal that can be started.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Goal {
    request: GoalRequest,
    side: HandSide,
    task: Task,
    requirements: TaskRequirements,
    clearance_margin_m: f64,
}

impl Goal {
    /// Resolves the codes of a request and its task; [`GoalKind::CUSTOM`] by name, user tasks
    /// first. [`crate::check`] checks numbers and reach.
    ///
    /// # Errors
    /// The [`Reason`] for the refusal.
    ///
    /// ```
    /// use atas_core::Goal;
    /// use shm_schemas::{GoalKind, GoalRequest};
    ///
    /// let request = GoalRequest { kind: GoalKind::GRASP, ..GoalRequest::default() };
    /// assert_eq!(Goal::resolve(&request, &[])?.task().name.as_str(), "grasp");
    /// # Ok::<(), shm_schemas::Reason>(())
    /// ```
    pub fn resolve(request: &GoalRequest, own: &[Task]) -> Result<Self, Reason> {
        let unknown = |field: u32, code: u32| Reason::UnknownGoal { field, code };
        let task = match request.kind {
            GoalKind::CUSTOM => own
                .iter()
                .find(|task| task.name == request.task.as_str())
                .or_else(|| tasks::by_name(request.task.as_str()))
                .ok_or(Reason::UnknownTask)?,
            kind => tasks::for_kind(kind).ok_or(unknown(0, kind.0))?,
        };
        if !request.policy.is_known() {
            return Err(unknown(2, request.policy.0));
        }
        if !request.turn.is_known() {
            return Err(unknown(3, request.turn.0));
        }
        let hand = request.hand.index().ok_or(unknown(1, request.hand.0))?;
        Ok(Self::new(*request, HandSide::BOTH[hand], *task))
    }

    pub(crate) fn new(request: GoalRequest, side: HandSide, task: Task) -> Self {
        Self {
            request,
            side,
            requirements: task.requirements(),
            task,
            clearance_margin_m: 0.0,
        }
    }

    /// Sets the clearance margin of the path check, m.
    #[must_use]
    pub(crate) fn with_clearance_margin(self, clearance_margin_m: f64) -> Self {
        Self {
            clearance_margin_m,
            ..self
        }
    }

    /// Returns the lateral offset from the given grasp position within which the arms keep their
    /// clearance, m. Zero before the path check.
    #[must_use]
    pub fn clearance_margin_m(&self) -> f64 {
        self.clearance_margin_m
    }

    /// Returns the client's request.
    #[must_use]
    pub fn request(&self) -> &GoalRequest {
        &self.request
    }

    /// Returns the acting hand.
    #[must_use]
    pub fn side(&self) -> HandSide {
        self.side
    }

    /// Returns the task.
    #[must_use]
    pub fn task(&self) -> &Task {
        &self.task
    }

    /// Returns the task's requirements.
    #[must_use]
    pub fn requirements(&self) -> TaskRequirements {
        self.requirements
    }

    /// Returns the object's final position, m, and closing yaw, rad.
    #[must_use]
    pub fn destination(&self) -> ([f64; 3], f64) {
        let request = &self.request;
        if self.requirements.visits_target {
            (request.to_m, request.to_yaw_rad)
        } else {
            (request.from_m, request.from_yaw_rad)
        }
    }

    /// Returns the grasp height during transport, m: `lift_m` above the higher of start and
    /// destination.
    #[must_use]
    pub fn travel_height_m(&self) -> f64 {
        let ([.., to_m], _) = self.destination();
        let [.., from_m] = self.request.from_m;
        from_m.max(to_m) + self.request.lift_m
    }
}

/// State of the active goal.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct ActiveGoal {
    /// Request of the client.
    pub request: GoalRequest,
    /// Acting hand.
    pub side: HandSide,
    /// True if the other hand takes part.
    pub both_hands: bool,
    /// Current state.
    pub state: GoalState,
    /// Reason of an end without success.
    pub reason: Reason,
    /// Time paused in HOLD, s.
    pub paused_s: f64,
}

impl ActiveGoal {
    /// Creates the initial state.
    #[must_use]
    pub fn begin(goal: &Goal) -> Self {
        Self {
            request: goal.request,
            side: goal.side,
            both_hands: goal.requirements.both_hands,
            state: GoalState::ACCEPTED,
            reason: Reason::None,
            paused_s: 0.0,
        }
    }

    /// Returns whether this hand takes part.
    #[must_use]
    pub fn involves(&self, side: HandSide) -> bool {
        side == self.side || self.both_hands
    }

    /// Returns whether the goal ends when its client disconnects. Teleoperation always does: no
    /// other client can command the hand.
    #[must_use]
    pub fn is_attached(&self) -> bool {
        self.request.policy == GoalPolicy::ATTACHED || self.request.kind.is_stream()
    }
}
