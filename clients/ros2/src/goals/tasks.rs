//! Actions of `atas_msgs`: goals of the daemon with progress.

use atas_client::GoalProgress;
use atas_client::goal::{self, Target};
use shm_schemas::capacity::FINGERS;
use shm_schemas::{GoalKind, GoalRequest, GoalState, Hand, Turn};

use crate::wire::Action;
use crate::wire::action::{Assemble, Grasp, PickPlace, Release, Screw};
use crate::wire::atas::{
    AssembleFeedback, AssembleResult, GraspFeedback, GraspResult, ObjectTarget, PickPlaceFeedback,
    PickPlaceResult, ReleaseFeedback, ReleaseResult, ScrewFeedback, ScrewResult, TaskOutcome,
    TaskProgress,
};
use crate::wire::standard::Point;

/// Action that is one goal of the daemon.
pub(super) trait TaskAction: Action {
    /// Name of the action below the namespace.
    const NAME: &'static str;
    /// Returns the daemon's goal.
    fn request(goal: &Self::Goal) -> Result<GoalRequest, String>;
    /// Returns the result with this outcome.
    fn result(outcome: TaskOutcome) -> Self::Result;
    /// Returns the progress message.
    fn feedback(progress: TaskProgress) -> Self::Feedback;
}

macro_rules! task_actions {
    ($($action:ident, $name:literal, $result:ident, $feedback:ident: $request:expr;)*) => {$(
        impl TaskAction for $action {
            const NAME: &'static str = $name;
            fn request(goal: &Self::Goal) -> Result<GoalRequest, String> {
                let request: fn(&Self::Goal) -> Result<GoalRequest, String> = $request;
                request(goal)
            }
            fn result(outcome: TaskOutcome) -> Self::Result {
                $result { outcome }
            }
            fn feedback(progress: TaskProgress) -> Self::Feedback {
                $feedback { progress }
            }
        }
    )*};
}

task_actions! {
    Grasp, "grasp", GraspResult, GraspFeedback: |of| {
        Ok(goal::grasp(&target(&of.object), hand(&of.hand)?, of.lift_m, of.hold_s))
    };
    PickPlace, "pick_place", PickPlaceResult, PickPlaceFeedback: |of| {
        let to_m = position(&of.destination);
        Ok(goal::pick_place(&target(&of.object), hand(&of.hand)?, to_m, of.lift_m))
    };
    Screw, "screw", ScrewResult, ScrewFeedback: |of| {
        let turn = if of.anticlockwise { Turn::ANTICLOCKWISE } else { Turn::CLOCKWISE };
        Ok(GoalRequest { turn, ..goal::screw(&target(&of.cap), hand(&of.hand)?) })
    };
    Assemble, "assemble", AssembleResult, AssembleFeedback: |of| {
        let on_bottle = Target {
            at_m: position(&of.on_bottle),
            yaw_rad: of.on_bottle_yaw_rad,
            ..target(&of.cap)
        };
        let (cap, hand) = (target(&of.cap), hand(&of.hand)?);
        Ok(goal::assemble(&cap, &on_bottle, of.bottle_width_m, hand))
    };
    Release, "release", ReleaseResult, ReleaseFeedback: |of| {
        Ok(GoalRequest { kind: GoalKind::RELEASE, hand: hand(&of.hand)?, ..GoalRequest::default() })
    };
}

fn hand(name: &str) -> Result<Hand, String> {
    Hand::from_name(name).ok_or_else(|| {
        let shown: String = name.chars().take(20).collect();
        format!("goal rejected: hand is {shown:?}; use left or right")
    })
}

fn position(point: &Point) -> [f64; 3] {
    [point.x, point.y, point.z]
}

fn target(of: &ObjectTarget) -> Target {
    Target {
        at_m: position(&of.position),
        yaw_rad: of.yaw_rad,
        width_m: of.width_m,
        top_m: of.top_m,
        max_force_n: of.max_force_n,
    }
}

/// Returns an error if a number of the goal is not finite.
pub(super) fn check(request: &GoalRequest) -> Result<(), String> {
    let names = GoalRequest::VALUE_NAMES.iter();
    let wrong = names
        .zip(request.values())
        .find(|(_, value)| !value.is_finite());
    wrong.map_or(Ok(()), |(name, value)| {
        Err(format!(
            "goal rejected: {name} is {value}; give a finite number"
        ))
    })
}

/// Returns the outcome of a goal that did not reach the daemon.
pub(super) fn unsent(cause: &str) -> TaskOutcome {
    TaskOutcome {
        state: GoalState::REJECTED.name().to_owned(),
        cause: cause.to_owned(),
        ..TaskOutcome::default()
    }
}

/// Returns the outcome of an ended goal.
pub(super) fn outcome(progress: &GoalProgress) -> TaskOutcome {
    let (last, figures) = (progress.last(), progress.figures());
    let succeeded = last.state == GoalState::SUCCEEDED;
    TaskOutcome {
        state: last.state.name().to_owned(),
        cause: if succeeded {
            String::new()
        } else {
            progress.text()
        },
        cause_code: if succeeded { 0 } else { last.reason.cause.0 },
        normal_n: figures.normal_n[..FINGERS].to_vec(),
        stiffness_n_m: figures.stiffness_n_m,
        friction: figures.friction,
        lifted_m: figures.lifted_m,
        took_s: progress.took_s(),
    }
}

/// Returns the progress of a running goal.
pub(super) fn task_progress(progress: &GoalProgress) -> TaskProgress {
    let last = progress.last();
    TaskProgress {
        step: last.step.to_string(),
        progress: last.progress,
        normal_n: last.figures.normal_n.to_vec(),
        lifted_m: last.figures.lifted_m,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::wire::atas::GraspGoal;

    fn grasp_goal() -> GraspGoal {
        GraspGoal {
            hand: "right".to_owned(),
            object: ObjectTarget {
                position: Point {
                    x: 0.3,
                    y: -0.1,
                    z: 0.03,
                },
                width_m: 0.05,
                max_force_n: 2.0,
                ..ObjectTarget::default()
            },
            lift_m: 0.04,
            hold_s: 1.0,
        }
    }

    #[test]
    fn goal_of_ros_becomes_goal_of_the_daemon() {
        let request = Grasp::request(&grasp_goal()).expect("valid");
        assert_eq!((request.kind, request.hand), (GoalKind::GRASP, Hand::RIGHT));
        assert_eq!(request.from_m, [0.3, -0.1, 0.03]);
        assert_eq!((request.width_m, request.max_force_n), (0.05, 2.0));
        assert_eq!(check(&request), Ok(()));
    }

    #[test]
    fn invalid_goals_are_rejected_with_value() {
        let mut goal = grasp_goal();
        goal.hand = "third".repeat(1000);
        let error = Grasp::request(&goal).expect_err("no such hand");
        assert!(
            error.contains("use left or right") && error.len() < 100,
            "{error}"
        );
        let mut goal = grasp_goal();
        goal.object.width_m = f64::NAN;
        let error = check(&Grasp::request(&goal).expect("parsed")).expect_err("not finite");
        assert_eq!(error, "goal rejected: width is NaN; give a finite number");
    }
}
