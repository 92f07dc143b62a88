//! Node over DDS (`ros2-client`).

use std::fmt::Display;

use anyhow::anyhow;
use byteorder::LittleEndian;
use ros2_client::action::ActionServerQosPolicies;
use ros2_client::dds::rustdds::{
    DomainParticipantStatusListener, StatusEvented as _,
    dds::statusevents::{DomainParticipantStatusEvent, LostReason},
};
use ros2_client::qos::{Durability, History, QosProfile, Reliability, WhenFull};
use ros2_client::{
    ActionServer, ActionTypeName, Context, ContextOptions, MessageTypeName, Name, NodeName,
    Publisher, RmwRequestId, Server, ServiceMapping as DdsMapping, ServiceTypeName, Subscription,
};
use serde::Serialize;
use serde::de::DeserializeOwned;

use super::requests::Waiting;
use super::{
    ActionPorts, Caller, Carried, NodeOptions, Publish, Quality, Serve, ServiceMapping, Subscribe,
};
use crate::wire::action::{
    FeedbackMessage, GetResultRequest, GetResultResponse, SendGoalRequest, SendGoalResponse,
};
use crate::wire::standard::{CancelGoalRequest, CancelGoalResponse, GoalStatusArray};
use crate::wire::{Action, Message, Service};

/// Messages kept for a slow peer of a service. Design choice: requests of one poll interval.
const SERVICE_DEPTH: usize = 100;

/// Node over DDS.
pub(crate) struct DdsNode {
    node: ros2_client::Node,
    mapping: DdsMapping,
    losses: Losses,
}

/// Participants that were lost by time-out.
///
/// Such a peer may have been cut off without losing the bridge. It then does not announce its
/// readers and writers again, and RustDDS ignores its repeated announcement. Only a new participant
/// on this side helps.
struct Losses {
    listener: DomainParticipantStatusListener,
    any: bool,
}

impl Losses {
    fn poll(&mut self) -> bool {
        while let Some(event) = self.listener.try_recv_status() {
            let reason = match event {
                DomainParticipantStatusEvent::ParticipantLost { reason, .. } => reason,
                _ => continue,
            };
            self.any |= matches!(reason, LostReason::Timeout { .. });
        }
        self.any
    }
}

impl DdsNode {
    pub(super) fn join(options: &NodeOptions) -> anyhow::Result<Self> {
        let context = Context::with_options(ContextOptions::new().domain_id(options.domain))
            .map_err(|error| {
                anyhow!(
                    "could not join ROS domain {}: {error}; check that a network interface is up",
                    options.domain
                )
            })?;
        let name = NodeName::new(&options.namespace, &options.name)
            .map_err(|error| anyhow!("invalid node name {}: {error:?}", options.name))?;
        // The services of parameters are those of the bridge, because ros2-client's have one
        // mapping only.
        let losses = Losses {
            listener: context.domain_participant().status_listener(),
            any: false,
        };
        let node_options = ros2_client::NodeOptions::new().start_parameter_services(false);
        let node = context
            .new_node(name, node_options)
            .map_err(|error| anyhow!("could not create the node: {error}"))?;
        let mapping = match options.services {
            ServiceMapping::Fastdds => DdsMapping::Enhanced,
            ServiceMapping::Cyclonedds => DdsMapping::Cyclone,
        };
        Ok(Self {
            node,
            mapping,
            losses,
        })
    }

    /// Returns true if a peer may see the bridge without its endpoints, until it joins again.
    pub(super) fn must_rejoin(&mut self) -> bool {
        self.losses.poll()
    }

    pub(super) fn publisher<M: Message>(
        &mut self,
        topic: &str,
        quality: Quality,
    ) -> anyhow::Result<Box<dyn Publish<M>>> {
        let profile = profile(quality);
        let of = self.topic::<M>(topic, &profile)?;
        let publisher = self.node.create_publisher::<M>(&of, Some(profile));
        Ok(Box::new(publisher.map_err(|error| failure(topic, error))?))
    }

    pub(super) fn subscription<M: Message>(
        &mut self,
        topic: &str,
        quality: Quality,
    ) -> anyhow::Result<Box<dyn Subscribe<M>>> {
        let profile = profile(quality);
        let of = self.topic::<M>(topic, &profile)?;
        let reader = self.node.create_subscription::<M>(&of, Some(profile));
        Ok(Box::new(reader.map_err(|error| failure(topic, error))?))
    }

    fn topic<M: Message>(
        &self,
        topic: &str,
        profile: &QosProfile,
    ) -> anyhow::Result<ros2_client::dds::rustdds::Topic> {
        let (package, name) = split(&M::type_name());
        let of = MessageTypeName::new(&package, &name);
        let made = self.node.create_topic(&parsed(topic)?, of, profile);
        made.map_err(|error| failure(topic, error))
    }

    pub(super) fn server<S: Service>(&mut self, name: &str) -> anyhow::Result<Box<dyn Serve<S>>>
    where
        S::Request: Carried,
        S::Response: Carried,
    {
        let (package, of) = split(&S::type_name());
        let server = self.node.create_server::<S::Request, S::Response>(
            self.mapping,
            &parsed(name)?,
            &ServiceTypeName::new(&package, &of),
            service_profile(),
            service_profile(),
        );
        Ok(Box::new(DdsServer::<S> {
            server: server.map_err(|error| failure(name, error))?,
            waiting: Waiting::default(),
        }))
    }

    pub(super) fn action<A: Action>(
        &mut self,
        name: &str,
    ) -> anyhow::Result<Box<dyn ActionPorts<A>>> {
        let (package, of) = split(&A::type_name());
        let qualities = ActionServerQosPolicies {
            goal_service: service_profile(),
            result_service: service_profile(),
            cancel_service: service_profile(),
            feedback_publisher: profile(Quality::STREAM),
            status_publisher: profile(Quality::LATCHED),
        };
        let server = self
            .node
            .create_action_server::<A::Goal, A::Result, A::Feedback>(
                self.mapping,
                &parsed(name)?,
                &ActionTypeName::new(&package, &of),
                qualities,
            );
        Ok(Box::new(DdsAction::<A> {
            server: server.map_err(|error| failure(name, error))?,
            waiting: Waiting::default(),
        }))
    }
}

/// Returns package and name of a type, for example `std_srvs` and `Trigger`.
fn split(type_name: &str) -> (String, String) {
    let package = type_name.split('/').next().unwrap_or_default();
    let name = type_name.rsplit('/').next().unwrap_or_default();
    (package.to_owned(), name.to_owned())
}

fn parsed(name: &str) -> anyhow::Result<Name> {
    Name::parse(name).map_err(|error| {
        anyhow!("invalid ROS name {name:?}: {error:?}; use letters, digits and underscores")
    })
}

fn failure(name: &str, error: impl Display) -> anyhow::Error {
    anyhow!("could not open {name} over DDS: {error}")
}

fn profile(quality: Quality) -> QosProfile {
    let reliability = if quality.reliable {
        // A reader that does not acknowledge loses messages; the bridge never waits for it.
        Reliability::Reliable {
            when_full: WhenFull::Fail,
        }
    } else {
        Reliability::BestEffort
    };
    let durability = if quality.latched {
        Durability::TransientLocal
    } else {
        Durability::Volatile
    };
    let depth = quality.depth;
    QosProfile::publisher_default()
        .reliability(reliability)
        .durability(durability)
        .history(History::KeepLast { depth })
}

fn service_profile() -> QosProfile {
    profile(Quality {
        depth: SERVICE_DEPTH,
        ..Quality::STREAM
    })
}

impl<M: Message> Publish<M> for Publisher<M> {
    fn publish(&self, message: M) -> anyhow::Result<()> {
        let sent = Publisher::publish(self, message);
        sent.map_err(|error| anyhow!("could not publish: {error}"))
    }
}

impl<M: Message> Subscribe<M> for Subscription<M> {
    fn take(&mut self) -> anyhow::Result<Option<M>> {
        let taken = Subscription::take(self);
        let taken = taken.map_err(|error| anyhow!("could not read a message: {error}"))?;
        Ok(taken.map(|(message, _)| message))
    }
}

struct DdsServer<S: Service>
where
    S::Request: Carried,
    S::Response: Carried,
{
    server: Server<S::Request, S::Response>,
    waiting: Waiting<RmwRequestId>,
}

impl<S: Service> Serve<S> for DdsServer<S>
where
    S::Request: Carried,
    S::Response: Carried,
{
    fn take(&mut self) -> anyhow::Result<Option<(Caller, S::Request)>> {
        let taken = self.server.receive_request().map_err(unreadable)?;
        Ok(taken.map(|(from, request)| (self.waiting.add(from), request)))
    }

    fn respond(&mut self, to: Caller, response: S::Response) -> anyhow::Result<()> {
        let to = self.waiting.remove(to)?;
        let sent = self.server.send_response(to, response);
        sent.map_err(unsent)
    }
}

fn unreadable(error: impl Display) -> anyhow::Error {
    anyhow!("could not read a request: {error}")
}

fn unsent(error: impl Display) -> anyhow::Error {
    anyhow!("could not answer a request: {error}")
}

struct DdsAction<A: Action> {
    server: ActionServer<A::Goal, A::Result, A::Feedback>,
    waiting: Waiting<RmwRequestId>,
}

/// Converts between two Rust types of one ROS 2 type: ros2-client's and the bridge's.
fn converted<T: DeserializeOwned>(from: &impl Serialize) -> anyhow::Result<T> {
    let bytes = cdr_encoding::to_vec::<_, LittleEndian>(from)?;
    Ok(cdr_encoding::from_bytes::<T, LittleEndian>(&bytes)?.0)
}

impl<A: Action> ActionPorts<A> for DdsAction<A> {
    fn take_goal(&mut self) -> anyhow::Result<Option<(Caller, SendGoalRequest<A>)>> {
        let Some((from, request)) = self.server.receive_goal().map_err(unreadable)? else {
            return Ok(None);
        };
        let request = SendGoalRequest::new(converted(&request.goal_id)?, request.goal);
        Ok(Some((self.waiting.add(from), request)))
    }

    fn respond_goal(&mut self, to: Caller, response: SendGoalResponse<A>) -> anyhow::Result<()> {
        let to = self.waiting.remove(to)?;
        let sent = self.server.send_goal_response(to, converted(&response)?);
        sent.map_err(unsent)
    }

    fn take_cancel(&mut self) -> anyhow::Result<Option<(Caller, CancelGoalRequest)>> {
        let taken = self.server.receive_cancel_request().map_err(unreadable)?;
        let Some((from, request)) = taken else {
            return Ok(None);
        };
        Ok(Some((self.waiting.add(from), converted(&request)?)))
    }

    fn respond_cancel(&mut self, to: Caller, response: CancelGoalResponse) -> anyhow::Result<()> {
        let to = self.waiting.remove(to)?;
        let sent = self.server.send_cancel_response(to, converted(&response)?);
        sent.map_err(unsent)
    }

    fn take_result(&mut self) -> anyhow::Result<Option<(Caller, GetResultRequest<A>)>> {
        let taken = self.server.receive_result_request().map_err(unreadable)?;
        let Some((from, request)) = taken else {
            return Ok(None);
        };
        let request = GetResultRequest::new(converted(&request.goal_id)?);
        Ok(Some((self.waiting.add(from), request)))
    }

    fn respond_result(&mut self, to: Caller, response: GetResultResponse<A>) -> anyhow::Result<()> {
        let to = self.waiting.remove(to)?;
        let sent = self.server.send_result(to, converted(&response)?);
        sent.map_err(unsent)
    }

    fn feedback(&mut self, message: FeedbackMessage<A>) -> anyhow::Result<()> {
        let goal_id = converted(&message.goal_id)?;
        let sent = self.server.send_feedback(goal_id, message.feedback);
        sent.map_err(|error| anyhow!("could not publish the progress of a goal: {error}"))
    }

    fn statuses(&mut self, message: GoalStatusArray) -> anyhow::Result<()> {
        let sent = self.server.send_goal_statuses(converted(&message)?);
        sent.map_err(|error| anyhow!("could not publish the states of goals: {error}"))
    }
}
