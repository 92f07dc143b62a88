//! Messages of package `atas_msgs`. Its `.msg` and `.action` files have the same fields (tested by
//! their type hashes).

use super::messages;
use super::standard::{Header, Point, Uuid};

messages! {
    /// State of one fingertip.
    FingertipState as "atas_msgs/msg/FingertipState" {
        /// True while the fingertip touches something.
        in_contact: bool,
        /// Normal force F_n, N.
        normal_n: f32,
        /// Tangential force F_t, N.
        tangential_n: f32,
        /// Increase of the tangential force dF_t, N.
        tangential_increment_n: f32,
        /// Friction utilisation S; 1 means slip.
        utilisation: f32,
        /// Estimated friction coefficient.
        friction: f32,
        /// Commanded closing speed, m/s.
        closing_m_s: f32,
    }
    /// State of one hand and of the object that it holds.
    HandState as "atas_msgs/msg/HandState" {
        /// Time of the tick; frame of the base.
        header: Header,
        /// `left` or `right`.
        hand: String,
        /// Names of the active modules.
        active_modules: Vec<String>,
        /// Number of the task step.
        step: u32,
        /// Minimum grip force F_1, N.
        f1_n: f32,
        /// Force limit F_2, N.
        f2_n: f32,
        /// Stiffness of the object, N/m; 0 while unknown.
        stiffness_n_m: f32,
        /// Distance between the fingertips, m; NaN without joint states.
        opening_m: f64,
        /// Commanded position of the hand's centre, base frame, m.
        centre_m: Point,
        /// True if every grasp side touches something.
        holds_object: bool,
        /// Vertical load of the object on the fingertips, N; its weight while it is suspended.
        load_n: f32,
        /// Lowest estimated friction coefficient of the touching fingertips; 0 without contact.
        friction: f32,
        /// Highest friction utilisation S of the touching fingertips; 1 means slip.
        friction_utilisation: f32,
        /// Fingertips.
        fingertips: Vec<FingertipState>,
    }
    /// State of the daemon and of its goal.
    DaemonState as "atas_msgs/msg/DaemonState" {
        /// Time of the status.
        header: Header,
        /// Version of the daemon.
        version: String,
        /// `init`, `ready`, `run`, `hold`, `safe-stop` or `fault`.
        mode: String,
        /// Reason of the mode, else empty.
        reason: String,
        /// True if a daemon reports.
        alive: bool,
        /// Task of the active or last goal, empty without one.
        task: String,
        /// State of that goal.
        goal_state: String,
        /// Step of that goal.
        step: String,
        /// Reason of its end without success, else empty.
        goal_reason: String,
        /// Executed ticks.
        ticks: u64,
        /// Missed ticks.
        missed_ticks: u64,
    }
    /// Change of the state of a goal of this bridge, with its cause.
    GoalEvent as "atas_msgs/msg/GoalEvent" {
        /// Time of the change.
        header: Header,
        /// Name of the action.
        action: String,
        /// Identifier of the goal.
        goal_id: Uuid,
        /// New state, `action_msgs/msg/GoalStatus`.
        status: i8,
        /// Task step, or empty.
        step: String,
        /// Cause of an end without success, else empty.
        cause: String,
    }
    /// Object to grasp.
    ObjectTarget as "atas_msgs/msg/ObjectTarget" {
        /// Point between the fingertips, base frame, m.
        position: Point,
        /// Direction of the closing axis from x towards y, rad.
        yaw_rad: f64,
        /// Expected width along the closing axis, m.
        width_m: f64,
        /// Height of the object above the point, m; 0 if unknown.
        top_m: f64,
        /// Largest permitted force per grasp side, N; 0 without limit.
        max_force_n: f64,
    }
    /// Progress of a task.
    TaskProgress as "atas_msgs/msg/TaskProgress" {
        /// Task step.
        step: String,
        /// Fraction done, 0 to 1.
        progress: f32,
        /// Normal force per fingertip, N.
        normal_n: Vec<f32>,
        /// Height by which the object is lifted, m.
        lifted_m: f32,
    }
    /// Result of a task.
    TaskOutcome as "atas_msgs/msg/TaskOutcome" {
        /// `succeeded`, `rejected`, `refused`, `failed` or `cancelled`.
        state: String,
        /// Last step, cause with value and limit, and remedy; empty after success.
        cause: String,
        /// Code of the cause; the page "Events, modules and causes" lists them.
        cause_code: u32,
        /// Normal force per fingertip, N.
        normal_n: Vec<f32>,
        /// Stiffness of the object, N/m; 0 while unknown.
        stiffness_n_m: f32,
        /// Lowest estimated friction coefficient; 0 while unknown.
        friction: f32,
        /// Height by which the object was lifted, m.
        lifted_m: f32,
        /// Duration, s.
        took_s: f64,
    }
    /// Goal of a grasp.
    GraspGoal as "atas_msgs/action/Grasp_Goal" {
        /// `left` or `right`.
        hand: String,
        /// Object.
        object: ObjectTarget,
        /// Lift, m.
        lift_m: f64,
        /// Time to hold after the lift, s.
        hold_s: f64,
    }
    /// Result of a grasp.
    GraspResult as "atas_msgs/action/Grasp_Result" {
        /// Outcome.
        outcome: TaskOutcome,
    }
    /// Progress of a grasp.
    GraspFeedback as "atas_msgs/action/Grasp_Feedback" {
        /// Progress.
        progress: TaskProgress,
    }
    /// Goal of pick-place.
    PickPlaceGoal as "atas_msgs/action/PickPlace_Goal" {
        /// `left` or `right`.
        hand: String,
        /// Object.
        object: ObjectTarget,
        /// Destination of the point between the fingertips, base frame, m.
        destination: Point,
        /// Lift, m.
        lift_m: f64,
    }
    /// Result of pick-place.
    PickPlaceResult as "atas_msgs/action/PickPlace_Result" {
        /// Outcome.
        outcome: TaskOutcome,
    }
    /// Progress of pick-place.
    PickPlaceFeedback as "atas_msgs/action/PickPlace_Feedback" {
        /// Progress.
        progress: TaskProgress,
    }
    /// Goal of screwing.
    ScrewGoal as "atas_msgs/action/Screw_Goal" {
        /// `left` or `right`.
        hand: String,
        /// Cap.
        cap: ObjectTarget,
        /// True turns anticlockwise, seen from above.
        anticlockwise: bool,
    }
    /// Result of screwing.
    ScrewResult as "atas_msgs/action/Screw_Result" {
        /// Outcome.
        outcome: TaskOutcome,
    }
    /// Progress of screwing.
    ScrewFeedback as "atas_msgs/action/Screw_Feedback" {
        /// Progress.
        progress: TaskProgress,
    }
    /// Goal of assembly.
    AssembleGoal as "atas_msgs/action/Assemble_Goal" {
        /// Hand that turns the cap: `left` or `right`.
        hand: String,
        /// Cap on its stand.
        cap: ObjectTarget,
        /// Point between the fingertips with the cap on the bottle, base frame, m.
        on_bottle: Point,
        /// Direction of the closing axis there, rad.
        on_bottle_yaw_rad: f64,
        /// Width of the bottle where the other hand holds it, m.
        bottle_width_m: f64,
    }
    /// Result of assembly.
    AssembleResult as "atas_msgs/action/Assemble_Result" {
        /// Outcome.
        outcome: TaskOutcome,
    }
    /// Progress of assembly.
    AssembleFeedback as "atas_msgs/action/Assemble_Feedback" {
        /// Progress.
        progress: TaskProgress,
    }
    /// Goal of a release.
    ReleaseGoal as "atas_msgs/action/Release_Goal" {
        /// `left` or `right`.
        hand: String,
    }
    /// Result of a release.
    ReleaseResult as "atas_msgs/action/Release_Result" {
        /// Outcome.
        outcome: TaskOutcome,
    }
    /// Progress of a release.
    ReleaseFeedback as "atas_msgs/action/Release_Feedback" {
        /// Progress.
        progress: TaskProgress,
    }
}
