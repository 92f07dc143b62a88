//! List of all interfaces with their type hashes, for comparison with other implementations.

use super::action::{
    Action, Assemble, FeedbackMessage, GetResult, Grasp, GripperCommandAction,
    ParallelGripperAction, PickPlace, Release, Screw, SendGoal,
};
use super::atas::{DaemonState, GoalEvent, HandState};
use super::parameters as of_parameters;
use super::standard as of;
use super::{Message, Service, message_hash, service_hash};

/// Name and type hash of an interface.
pub type Entry = (String, String);

fn message<M: Message>() -> Entry {
    (M::type_name(), message_hash::<M>())
}

fn service<S: Service>() -> Entry {
    (S::type_name(), service_hash::<S>())
}

fn action<A: Action>() -> [Entry; 6] {
    [
        message::<A::Goal>(),
        message::<A::Result>(),
        message::<A::Feedback>(),
        message::<FeedbackMessage<A>>(),
        service::<SendGoal<A>>(),
        service::<GetResult<A>>(),
    ]
}

/// Returns all interfaces of the bridge.
#[must_use]
pub fn entries() -> Vec<Entry> {
    let messages = [
        message::<of::JointState>(),
        message::<of::Transforms>(),
        message::<of::WrenchStamped>(),
        message::<of::PointCloud>(),
        message::<of::Text>(),
        message::<of::Log>(),
        message::<of::DiagnosticArray>(),
        message::<of::Float64Array>(),
        message::<of::JointTrajectory>(),
        message::<of::GoalStatusArray>(),
        message::<of_parameters::ParameterEvent>(),
        message::<HandState>(),
        message::<DaemonState>(),
        message::<GoalEvent>(),
    ];
    let services = [
        service::<of::Trigger>(),
        service::<of::CancelGoal>(),
        service::<of_parameters::GetParameters>(),
        service::<of_parameters::GetParameterTypes>(),
        service::<of_parameters::SetParameters>(),
        service::<of_parameters::SetParametersAtomically>(),
        service::<of_parameters::ListParameters>(),
        service::<of_parameters::DescribeParameters>(),
    ];
    let actions = [
        action::<GripperCommandAction>(),
        action::<ParallelGripperAction>(),
        action::<Grasp>(),
        action::<PickPlace>(),
        action::<Screw>(),
        action::<Assemble>(),
        action::<Release>(),
    ];
    let actions = actions.into_iter().flatten();
    messages
        .into_iter()
        .chain(services)
        .chain(actions)
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Hashes of a ROS 2 installation (Jazzy), as published by rmw_zenoh peers.
    #[test]
    fn hashes_equal_those_of_a_ros_installation() {
        let entries = entries();
        let check = |name: &str, expected: &str| {
            let found = entries
                .iter()
                .find(|(of, _)| of == name)
                .expect("in the list");
            assert_eq!(found.1, format!("RIHS01_{expected}"), "{name}");
        };
        check(
            "rcl_interfaces/srv/GetParameters",
            "bf9803d5c74cf989a5de3e0c2e99444599a627c7ff75f97b8c05b01003675cbc",
        );
        check(
            "rcl_interfaces/srv/DescribeParameters",
            "845b484d71eb0673dae682f2e3ba3c4851a65a3dcfb97bddd82c5b57e91e4cff",
        );
        check(
            "rcl_interfaces/msg/ParameterEvent",
            "043e627780fcad87a22d225bc2a037361dba713fca6a6b9f4b869a5aa0393204",
        );
    }
}
