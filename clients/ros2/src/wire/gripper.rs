//! Messages of the gripper actions of `control_msgs`.

use super::messages;
use super::standard::JointState;

messages! {
    /// Position and force of a gripper.
    GripperCommand as "control_msgs/msg/GripperCommand" {
        /// Distance between the fingertips, m.
        position: f64,
        /// Largest force, N; 0 without limit.
        max_effort: f64,
    }
    /// Goal of a gripper.
    GripperGoal as "control_msgs/action/GripperCommand_Goal" {
        /// Command.
        command: GripperCommand,
    }
    /// Result of a gripper.
    GripperResult as "control_msgs/action/GripperCommand_Result" {
        /// Distance between the fingertips, m.
        position: f64,
        /// Force, N.
        effort: f64,
        /// True if the fingers stopped before the commanded distance.
        stalled: bool,
        /// True if the fingers reached the commanded distance.
        reached_goal: bool,
    }
    /// Progress of a gripper.
    GripperFeedback as "control_msgs/action/GripperCommand_Feedback" {
        /// Distance between the fingertips, m.
        position: f64,
        /// Force, N.
        effort: f64,
        /// True if the fingers do not move.
        stalled: bool,
        /// True if the fingers reached the commanded distance.
        reached_goal: bool,
    }
    /// Goal of a parallel gripper.
    ParallelGripperGoal as "control_msgs/action/ParallelGripperCommand_Goal" {
        /// Distance between the fingertips, m, and largest force, N.
        command: JointState,
    }
    /// Result of a parallel gripper.
    ParallelGripperResult as "control_msgs/action/ParallelGripperCommand_Result" {
        /// Distance between the fingertips, m, and force, N.
        state: JointState,
        /// True if the fingers stopped before the commanded distance.
        stalled: bool,
        /// True if the fingers reached the commanded distance.
        reached_goal: bool,
    }
    /// Progress of a parallel gripper.
    ParallelGripperFeedback as "control_msgs/action/ParallelGripperCommand_Feedback" {
        /// Distance between the fingertips, m, and force, N.
        state: JointState,
    }
}
