//! Goals: what is asked is checked here, before anything moves.
//!
//! A [`GoalRequest`] is whatever a client sent. A [`Goal`] has a known hand, policy and turn, and its task with it: it can
//! be started whatever becomes of the configuration, and recorded as it was.

use crate::tasks::{self, Demands, Task, from_the_side};
use crate::wiring::Wiring;
use core::f64::consts::TAU;
use nalgebra::Vector3;
use robot_model::{GraspFrame, RobotModel, Side, Unreachable, Workspace, clearance_m};
use shm_schemas::{Cause, GoalKind, GoalPolicy, GoalRequest, GoalState, Reason};

/// Highest lift, m, and longest hold, s, that a goal may ask for (ours).
const LIFT_MAX_M: f64 = 0.15;
const HOLD_MAX_S: f64 = 3600.0;
/// Index of each checked value in [`GoalRequest::VALUE_NAMES`].
const FROM_X: usize = 0;
const FROM_YAW: usize = 3;
const TO_X: usize = 4;
const TO_YAW: usize = 7;
const WIDTH: usize = 8;
const LIFT: usize = 9;
const HOLD: usize = 10;
const HELPER_WIDTH: usize = 11;
/// Least distance between the arms, m (robot design: the proved motions keep 24 mm).
const CLEARANCE_M: f64 = 0.010;
/// How much wider than the cap the acting hand is while both hands are over the bottle, m.
const OPENINGS_M: [f64; 2] = [0.0, 0.024];

/// A goal that can be started.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Goal {
    request: GoalRequest,
    side: Side,
    task: Task,
    demands: Demands,
}

impl Goal {
    /// Looks up the codes of a request, and its task among the built-in ones or, for [`GoalKind::CUSTOM`], among the
    /// user's own. Says nothing about numbers and reach: that is [`check`]'s.
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
        }
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
pub struct ActiveGoal {
    /// What was asked.
    pub request: GoalRequest,
    /// Which hand acts.
    pub side: Side,
    /// Whether the other hand takes part.
    pub both_hands: bool,
    /// Where it stands.
    pub state: GoalState,
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
            paused_s: 0.0,
        }
    }

    /// Whether this hand takes part.
    #[must_use]
    pub fn involves(&self, side: Side) -> bool {
        side == self.side || self.both_hands
    }

    /// Whether the goal ends when its client goes away.
    #[must_use]
    pub fn is_attached(&self) -> bool {
        self.request.policy == GoalPolicy::ATTACHED
    }
}

/// What a goal is checked against.
#[derive(Clone, Copy, Debug)]
pub struct Circumstances<'a> {
    /// The robot.
    pub robot: &'a RobotModel,
    /// Its sensors.
    pub wiring: &'a Wiring,
    /// The user's own tasks.
    pub tasks: &'a [Task],
}

/// Checks a goal without moving anything: codes, numbers, sensors, reach. Takes some hundred microseconds because it
/// solves for the key postures, so call it off the tick.
///
/// # Errors
/// The [`Reason`] for the refusal.
pub fn check(request: &GoalRequest, now: &Circumstances<'_>) -> Result<Goal, Reason> {
    let goal = Goal::resolve(request, now.tasks)?;
    if let Some(index) = request.values().iter().position(|v| !v.is_finite()) {
        return Err(Reason::of(Cause::NOT_FINITE).about(index));
    }
    let hands = Side::BOTH.map(|side| (side, side == goal.side || goal.demands.both_hands));
    for (side, takes_part) in hands {
        if takes_part && !now.wiring.hands[side.index()].required {
            return Err(Reason::of(Cause::NO_SENSOR).about(side.index()));
        }
    }
    let visits = goal.demands.visits_source || goal.demands.visits_target;
    if visits || goal.demands.both_hands {
        check_range(request.from_yaw_rad, (-TAU, TAU), FROM_YAW)?;
        check_range(request.to_yaw_rad, (-TAU, TAU), TO_YAW)?;
        check_range(request.lift_m, (0.0, LIFT_MAX_M), LIFT)?;
        check_range(request.hold_s, (0.0, HOLD_MAX_S), HOLD)?;
        check_reach(&goal, now.robot)?;
    }
    if goal.demands.both_hands {
        check_together(&goal, now.robot)?;
    }
    Ok(goal)
}

fn check_range(value: f64, (lower, upper): (f64, f64), index: usize) -> Result<(), Reason> {
    let limit = if value < lower { lower } else { upper };
    if value >= lower && value <= upper {
        Ok(())
    } else {
        Err(Reason::limit(Cause::OUT_OF_RANGE, value, limit).about(index))
    }
}

/// Every place that the task takes the hand to must lie in the workspace, and the arm must have a posture for it.
fn check_reach(goal: &Goal, robot: &RobotModel) -> Result<(), Reason> {
    let request = &goal.request;
    if goal.demands.visits_source {
        check_place(goal, robot, request.from_m, request.from_yaw_rad, FROM_X)?;
    }
    if goal.demands.visits_target {
        check_place(goal, robot, request.to_m, request.to_yaw_rad, TO_X)?;
    }
    Ok(())
}

/// The hand must reach a place, and travel over it as high as the task lifts.
fn check_place(
    goal: &Goal,
    robot: &RobotModel,
    [x, y, z]: [f64; 3],
    yaw_rad: f64,
    index: usize,
) -> Result<(), Reason> {
    let (side, width_m) = (goal.side, goal.request.width_m);
    let hand = robot.hand(side);
    let workspace = Workspace::TWO_HAND_ARM;
    let (left, right) = (side == Side::Left, workspace.right_y_m);
    let y_m = if left { [-right[1], -right[0]] } else { right };
    let travel_m = goal.travel_height_m();
    let reach = |value: f64, [lower, upper]: [f64; 2], index: usize| {
        check_range(value, (lower, upper), index).map_err(|r| Reason {
            cause: Cause::UNREACHABLE,
            ..r
        })
    };
    reach(x, workspace.x_m, index)?;
    reach(y, y_m, index + 1)?;
    reach(z, workspace.z_m, index + 2)?;
    reach(travel_m, workspace.z_m, LIFT)?;
    reach(width_m, workspace.opening_m, WIDTH)?;
    for height_m in [z, travel_m] {
        let centre_m = Vector3::new(x, y, height_m);
        let yaw_rad = hand.closing_yaw_rad(&centre_m, yaw_rad);
        let frame = GraspFrame::from_above(centre_m, yaw_rad, width_m);
        if let Err(error) = hand.posture_for(&frame) {
            let error_m = error.best.tip_error_m;
            return Err(Reason::limit(Cause::UNREACHABLE, error_m, 0.0).about(index));
        }
    }
    Ok(())
}

/// The helping hand must reach the bottle, and the arms must keep clear of each other while both are over it.
fn check_together(goal: &Goal, robot: &RobotModel) -> Result<(), Reason> {
    let (request, helper) = (&goal.request, Side::BOTH[1 - goal.side.index()]);
    let [least_m, most_m] = Workspace::TWO_HAND_ARM.opening_m;
    check_range(request.helper_width_m, (least_m, most_m), HELPER_WIDTH)?;
    let (acting, helping) = (robot.hand(goal.side), robot.hand(helper));
    let unreachable = |error: Unreachable| {
        Reason::limit(Cause::UNREACHABLE, error.best.tip_error_m, 0.0).about(TO_X)
    };
    let held = helping
        .posture_for(&from_the_side(helping, request, 0.0))
        .map_err(unreachable)?;
    let held = helping.capsules(&helping.forward(&held.q_rad));
    let [x, y, z] = request.to_m;
    let heights_m = [0.0, 0.5, 1.0].map(|share| z + share * (goal.travel_height_m() - z));
    for (height_m, opening_m) in heights_m
        .into_iter()
        .flat_map(|z| OPENINGS_M.map(|o| (z, o)))
    {
        let centre_m = Vector3::new(x, y, height_m);
        let yaw_rad = acting.closing_yaw_rad(&centre_m, request.to_yaw_rad);
        let frame = GraspFrame::from_above(centre_m, yaw_rad, request.width_m + opening_m);
        let posture = acting.posture_for(&frame).map_err(unreachable)?;
        let clear_m = clearance_m(&acting.capsules(&acting.forward(&posture.q_rad)), &held);
        if clear_m < CLEARANCE_M {
            return Err(Reason::limit(Cause::ARMS_COLLIDE, clear_m, CLEARANCE_M));
        }
    }
    Ok(())
}
