//! Gripper actions of control_msgs: commands and results.

use crate::clock::present;
use crate::wire::Action;
use crate::wire::action::{GripperCommandAction, ParallelGripperAction};
use crate::wire::gripper::{
    GripperFeedback, GripperResult, ParallelGripperFeedback, ParallelGripperResult,
};
use crate::wire::standard::{Header, JointState};

/// Name of the only joint in the states of a parallel gripper.
const JOINT: &str = "opening";

/// Command of a gripper.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Command {
    /// Distance between the fingertips, m.
    pub(super) opening_m: f64,
    /// Largest force per grasp side, N; 0 without limit.
    pub(super) max_force_n: f64,
}

/// State of a gripper at the end of a command.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct GripperState {
    /// Distance between the fingertips, m.
    pub(super) opening_m: f64,
    /// Force of the stronger grasp side, N.
    pub(super) force_n: f64,
    /// True if the fingers stopped before the commanded distance.
    pub(super) stalled: bool,
    /// True if the fingers reached the commanded distance.
    pub(super) reached: bool,
    /// Cause of an end without success, else empty.
    pub(super) cause: String,
}

/// Action that commands a gripper.
pub(super) trait GripperAction: Action {
    /// Name of the action below the hand.
    const NAME: &'static str;
    /// Returns the command of a goal.
    fn command(goal: &Self::Goal) -> Result<Command, String>;
    /// Returns the result.
    fn result(state: &GripperState) -> Self::Result;
    /// Returns the progress message.
    fn feedback(state: &GripperState) -> Self::Feedback;
}

impl GripperAction for GripperCommandAction {
    const NAME: &'static str = "gripper_cmd";

    fn command(goal: &Self::Goal) -> Result<Command, String> {
        let of = &goal.command;
        checked(of.position, of.max_effort)
    }

    fn result(state: &GripperState) -> Self::Result {
        GripperResult {
            position: state.opening_m,
            effort: state.force_n,
            stalled: state.stalled,
            reached_goal: state.reached,
        }
    }

    fn feedback(state: &GripperState) -> Self::Feedback {
        GripperFeedback {
            position: state.opening_m,
            effort: state.force_n,
            stalled: state.stalled,
            reached_goal: state.reached,
        }
    }
}

impl GripperAction for ParallelGripperAction {
    const NAME: &'static str = "parallel_gripper_cmd";

    fn command(goal: &Self::Goal) -> Result<Command, String> {
        let of = &goal.command;
        let [opening_m] = of.position[..] else {
            return Err(format!(
                "goal rejected: the command has {} positions; give one, the distance between the \
                 fingertips in m",
                of.position.len()
            ));
        };
        match of.effort[..] {
            [] => checked(opening_m, 0.0),
            [max_force_n] => checked(opening_m, max_force_n),
            _ => Err(format!(
                "goal rejected: the command has {} efforts; give one, the largest force in N, or \
                 none",
                of.effort.len()
            )),
        }
    }

    fn result(state: &GripperState) -> Self::Result {
        ParallelGripperResult {
            state: joint_state(state),
            stalled: state.stalled,
            reached_goal: state.reached,
        }
    }

    fn feedback(state: &GripperState) -> Self::Feedback {
        ParallelGripperFeedback {
            state: joint_state(state),
        }
    }
}

/// Returns the state as joint state. The action has no field for a cause; the frame, which has no
/// meaning here, carries it.
fn joint_state(state: &GripperState) -> JointState {
    JointState {
        header: Header {
            stamp: present(),
            frame_id: state.cause.clone(),
        },
        name: vec![JOINT.to_owned()],
        position: vec![state.opening_m],
        velocity: Vec::new(),
        effort: vec![state.force_n],
    }
}

fn checked(opening_m: f64, max_force_n: f64) -> Result<Command, String> {
    if !opening_m.is_finite() {
        return Err(format!(
            "goal rejected: position is {opening_m}; give a finite number in m"
        ));
    }
    if !(max_force_n.is_finite() && max_force_n >= 0.0) {
        return Err(format!(
            "goal rejected: max_effort is {max_force_n}; give a force in N, or 0 without limit"
        ));
    }
    Ok(Command {
        opening_m,
        max_force_n,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::wire::gripper::{GripperCommand, GripperGoal, ParallelGripperGoal};

    #[test]
    fn invalid_commands_are_rejected_with_value() {
        let gripper = |position, max_effort| {
            let command = GripperCommand {
                position,
                max_effort,
            };
            GripperCommandAction::command(&GripperGoal { command })
        };
        let valid = Command {
            opening_m: 0.04,
            max_force_n: 2.0,
        };
        assert_eq!(gripper(0.04, 2.0), Ok(valid));
        let error = |result: Result<Command, String>| result.expect_err("invalid");
        assert!(error(gripper(f64::NAN, 2.0)).contains("position is NaN"));
        assert!(error(gripper(0.04, -1.0)).contains("max_effort is -1"));
        assert!(error(gripper(0.04, f64::INFINITY)).contains("max_effort is inf"));
        let parallel = |position: &[f64], effort: &[f64]| {
            let command = JointState {
                position: position.to_vec(),
                effort: effort.to_vec(),
                ..JointState::default()
            };
            ParallelGripperAction::command(&ParallelGripperGoal { command })
        };
        assert_eq!(parallel(&[0.04], &[2.0]), Ok(valid));
        assert_eq!(parallel(&[0.04], &[]).map(|of| of.max_force_n), Ok(0.0));
        assert!(error(parallel(&[], &[])).contains("0 positions"));
        assert!(error(parallel(&[0.01; 1000], &[])).contains("1000 positions"));
        assert!(error(parallel(&[0.04], &[1.0, 1.0])).contains("2 efforts"));
    }
}
