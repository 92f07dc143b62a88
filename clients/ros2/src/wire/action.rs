//! Actions, and the messages that ROS 2 derives from them.

use std::fmt::Debug;
use std::marker::PhantomData;

use serde::{Deserialize, Serialize};

use super::gripper::{
    GripperFeedback, GripperGoal, GripperResult, ParallelGripperFeedback, ParallelGripperGoal,
    ParallelGripperResult,
};
use super::standard::{Time, Uuid};
use super::{Field, Fields, Message, Nested, Service};

/// ROS 2 action.
pub trait Action: Clone + Debug + Default + Send + Sync + 'static {
    /// Goal.
    #[cfg(feature = "dds")]
    type Goal: Message + ros2_client::Message;
    /// Goal.
    #[cfg(not(feature = "dds"))]
    type Goal: Message;
    /// Result.
    #[cfg(feature = "dds")]
    type Result: Message + ros2_client::Message;
    /// Result.
    #[cfg(not(feature = "dds"))]
    type Result: Message;
    /// Progress.
    #[cfg(feature = "dds")]
    type Feedback: Message + ros2_client::Message;
    /// Progress.
    #[cfg(not(feature = "dds"))]
    type Feedback: Message;
    /// Returns the name, for example `control_msgs/action/GripperCommand`.
    fn type_name() -> String;
}

/// States of a goal (`action_msgs/msg/GoalStatus`).
pub mod status {
    /// Not known.
    pub const UNKNOWN: i8 = 0;
    /// Accepted, not begun.
    pub const ACCEPTED: i8 = 1;
    /// In progress.
    pub const EXECUTING: i8 = 2;
    /// Being cancelled.
    pub const CANCELING: i8 = 3;
    /// Succeeded.
    pub const SUCCEEDED: i8 = 4;
    /// Cancelled.
    pub const CANCELED: i8 = 5;
    /// Ended without success.
    pub const ABORTED: i8 = 6;
}

/// Results of a cancellation (`action_msgs/srv/CancelGoal`).
pub mod cancel {
    /// Goals are being cancelled.
    pub const DONE: i8 = 0;
    /// No goal matches.
    pub const REJECTED: i8 = 1;
    /// The goal is not known.
    pub const UNKNOWN_GOAL: i8 = 2;
    /// The goal has ended.
    pub const GOAL_TERMINATED: i8 = 3;
}

macro_rules! derived {
    ($($(#[$about:meta])* $name:ident, $suffix:literal { $($field:ident: $type:ty),* })*) => {$(
        $(#[$about])*
        #[derive(Clone, Debug, Default, Serialize, Deserialize)]
        #[serde(bound = "")]
        pub struct $name<A: Action> {
            $(#[doc = concat!("Field `", stringify!($field), "`.")] pub $field: $type,)*
            #[serde(skip)]
            of: PhantomData<A>,
        }

        impl<A: Action> $name<A> {
            /// Creates the message.
            #[must_use]
            pub fn new($($field: $type),*) -> Self {
                Self { $($field,)* of: PhantomData }
            }
        }

        impl<A: Action> Message for $name<A> {
            fn type_name() -> String { format!("{}{}", A::type_name(), $suffix) }

            fn fields(nested: &mut Nested) -> Fields {
                vec![$((stringify!($field), <$type as Field>::describe(nested))),*]
            }
        }

        #[cfg(feature = "dds")]
        impl<A: Action> ros2_client::Message for $name<A> {}
    )*};
}

derived! {
    /// Request of a goal.
    SendGoalRequest, "_SendGoal_Request" { goal_id: Uuid, goal: A::Goal }
    /// Answer to a goal.
    SendGoalResponse, "_SendGoal_Response" { accepted: bool, stamp: Time }
    /// Request of a result.
    GetResultRequest, "_GetResult_Request" { goal_id: Uuid }
    /// Result with the final state.
    GetResultResponse, "_GetResult_Response" { status: i8, result: A::Result }
    /// Progress of a goal.
    FeedbackMessage, "_FeedbackMessage" { goal_id: Uuid, feedback: A::Feedback }
}

/// Service that accepts goals of an action.
#[derive(Debug)]
pub struct SendGoal<A>(PhantomData<A>);

impl<A: Action> Service for SendGoal<A> {
    type Request = SendGoalRequest<A>;
    type Response = SendGoalResponse<A>;
    fn type_name() -> String {
        format!("{}_SendGoal", A::type_name())
    }
}

/// Service that delivers results of an action.
#[derive(Debug)]
pub struct GetResult<A>(PhantomData<A>);

impl<A: Action> Service for GetResult<A> {
    type Request = GetResultRequest<A>;
    type Response = GetResultResponse<A>;
    fn type_name() -> String {
        format!("{}_GetResult", A::type_name())
    }
}

macro_rules! actions {
    ($($(#[$about:meta])* $name:ident as $ros:literal: $goal:ty, $result:ty, $feedback:ty;)*) => {$(
        $(#[$about])*
        #[derive(Clone, Copy, Debug, Default)]
        pub struct $name;

        impl Action for $name {
            type Goal = $goal;
            type Result = $result;
            type Feedback = $feedback;
            fn type_name() -> String { $ros.to_owned() }
        }
    )*};
}

use super::atas;

actions! {
    /// Gripper, as MoveIt commands it.
    GripperCommandAction as "control_msgs/action/GripperCommand":
        GripperGoal, GripperResult, GripperFeedback;
    /// Parallel gripper, as newer versions of MoveIt command it.
    ParallelGripperAction as "control_msgs/action/ParallelGripperCommand":
        ParallelGripperGoal, ParallelGripperResult, ParallelGripperFeedback;
    /// Grasp, lift and hold.
    Grasp as "atas_msgs/action/Grasp": atas::GraspGoal, atas::GraspResult, atas::GraspFeedback;
    /// Grasp, carry and set down.
    PickPlace as "atas_msgs/action/PickPlace":
        atas::PickPlaceGoal, atas::PickPlaceResult, atas::PickPlaceFeedback;
    /// Turn a cap until it is tight.
    Screw as "atas_msgs/action/Screw": atas::ScrewGoal, atas::ScrewResult, atas::ScrewFeedback;
    /// Put a cap on a bottle and turn it until it is tight.
    Assemble as "atas_msgs/action/Assemble":
        atas::AssembleGoal, atas::AssembleResult, atas::AssembleFeedback;
    /// Open a hand in place and move it home.
    Release as "atas_msgs/action/Release":
        atas::ReleaseGoal, atas::ReleaseResult, atas::ReleaseFeedback;
}
