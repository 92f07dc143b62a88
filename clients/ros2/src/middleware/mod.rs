//! Middleware: publishers, subscriptions, servers and action servers of one node.
//!
//! The rest of the bridge does not know which middleware carries its messages.

#[cfg(feature = "dds")]
mod dds;
mod requests;
#[cfg(feature = "zenoh")]
mod zenoh;

use clap::ValueEnum;

use crate::wire::action::{
    FeedbackMessage, GetResultRequest, GetResultResponse, SendGoalRequest, SendGoalResponse,
};
use crate::wire::standard::{CancelGoalRequest, CancelGoalResponse, GoalStatusArray};
use crate::wire::{Action, Message, Service};

pub(crate) use requests::Caller;
#[cfg(test)]
pub(crate) use requests::test_caller;

/// Middleware.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Middleware {
    /// Data Distribution Service: Fast DDS, Cyclone DDS
    Dds,
    /// Zenoh: rmw_zenoh with its router
    Zenoh,
}

/// Mapping of services to DDS; peers with another one do not see the services.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum ServiceMapping {
    /// For peers with rmw_fastrtps
    Fastdds,
    /// For peers with rmw_cyclonedds
    Cyclonedds,
}

/// Quality of service of a topic. All topics are reliable, so that reliable and best-effort readers
/// receive them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Quality {
    /// Number of messages kept for a slow reader.
    pub(crate) depth: usize,
    /// True if a reader that joins later receives the last messages.
    pub(crate) latched: bool,
    /// False if a reader accepts lost messages.
    pub(crate) reliable: bool,
}

impl Quality {
    /// Streams of measurements.
    pub(crate) const STREAM: Self = Self::reliable(10);
    /// Events, all of which arrive.
    pub(crate) const EVENTS: Self = Self::reliable(1000);
    /// Values of which a later reader needs the last one.
    pub(crate) const LATCHED: Self = Self {
        latched: true,
        ..Self::reliable(1)
    };
    /// Readings of foreign streams, of which only the newest count.
    pub(crate) const NEWEST: Self = Self {
        reliable: false,
        ..Self::reliable(1)
    };

    const fn reliable(depth: usize) -> Self {
        Self {
            depth,
            latched: false,
            reliable: true,
        }
    }
}

/// Address of the node.
#[derive(Clone, Debug)]
pub struct NodeOptions {
    /// Middleware.
    pub(crate) middleware: Middleware,
    /// ROS domain.
    pub(crate) domain: u16,
    /// Namespace, for example `/atas`.
    pub(crate) namespace: String,
    /// Name.
    pub(crate) name: String,
    /// Mapping of services to DDS.
    pub(crate) services: ServiceMapping,
    /// Address of Zenoh's router.
    #[cfg_attr(not(feature = "zenoh"), expect(dead_code, reason = "Zenoh only"))]
    pub(crate) router: String,
}

/// Writer of a topic.
pub(crate) trait Publish<M>: Send {
    /// Sends a message; never waits for readers.
    ///
    /// # Errors
    /// The middleware rejects the message.
    fn publish(&self, message: M) -> anyhow::Result<()>;
}

/// Reader of a topic.
pub(crate) trait Subscribe<M>: Send {
    /// Returns the next message, if any.
    ///
    /// # Errors
    /// A message does not have the expected form; the next call reads the next one.
    fn take(&mut self) -> anyhow::Result<Option<M>>;
}

/// Server of a service.
pub(crate) trait Serve<S: Service>: Send {
    /// Returns the next request, if any.
    ///
    /// # Errors
    /// A request does not have the expected form; the next call reads the next one.
    fn take(&mut self) -> anyhow::Result<Option<(Caller, S::Request)>>;

    /// Answers a request.
    ///
    /// # Errors
    /// The middleware rejects the answer.
    fn respond(&mut self, to: Caller, response: S::Response) -> anyhow::Result<()>;
}

/// Services and topics of an action.
pub(crate) trait ActionPorts<A: Action>: Send {
    /// Returns the next goal, if any.
    ///
    /// # Errors
    /// A request does not have the expected form.
    fn take_goal(&mut self) -> anyhow::Result<Option<(Caller, SendGoalRequest<A>)>>;
    /// Answers a goal.
    ///
    /// # Errors
    /// The middleware rejects the answer.
    fn respond_goal(&mut self, to: Caller, response: SendGoalResponse<A>) -> anyhow::Result<()>;
    /// Returns the next cancellation, if any.
    ///
    /// # Errors
    /// A request does not have the expected form.
    fn take_cancel(&mut self) -> anyhow::Result<Option<(Caller, CancelGoalRequest)>>;
    /// Answers a cancellation.
    ///
    /// # Errors
    /// The middleware rejects the answer.
    fn respond_cancel(&mut self, to: Caller, response: CancelGoalResponse) -> anyhow::Result<()>;
    /// Returns the next request of a result, if any.
    ///
    /// # Errors
    /// A request does not have the expected form.
    fn take_result(&mut self) -> anyhow::Result<Option<(Caller, GetResultRequest<A>)>>;
    /// Answers a request of a result.
    ///
    /// # Errors
    /// The middleware rejects the answer.
    fn respond_result(&mut self, to: Caller, response: GetResultResponse<A>) -> anyhow::Result<()>;
    /// Publishes progress.
    ///
    /// # Errors
    /// The middleware rejects the message.
    fn feedback(&mut self, message: FeedbackMessage<A>) -> anyhow::Result<()>;
    /// Publishes the states of all goals.
    ///
    /// # Errors
    /// The middleware rejects the message.
    fn statuses(&mut self, message: GoalStatusArray) -> anyhow::Result<()>;
}

/// Node of the bridge.
pub(crate) enum Node {
    /// Over DDS.
    #[cfg(feature = "dds")]
    Dds(Box<dds::DdsNode>),
    /// Over Zenoh.
    #[cfg(feature = "zenoh")]
    Zenoh(Box<zenoh::ZenohNode>),
}

macro_rules! on_each {
    ($node:expr, $of:ident => $call:expr) => {
        match $node {
            #[cfg(feature = "dds")]
            Node::Dds($of) => $call,
            #[cfg(feature = "zenoh")]
            Node::Zenoh($of) => $call,
        }
    };
}

impl Node {
    /// Joins the ROS graph.
    ///
    /// # Errors
    /// The middleware is not part of this program, or does not start.
    pub(crate) fn join(options: &NodeOptions) -> anyhow::Result<Self> {
        match options.middleware {
            #[cfg(feature = "dds")]
            Middleware::Dds => Ok(Self::Dds(Box::new(dds::DdsNode::join(options)?))),
            #[cfg(feature = "zenoh")]
            Middleware::Zenoh => Ok(Self::Zenoh(Box::new(zenoh::ZenohNode::join(options)?))),
            #[allow(unreachable_patterns)]
            missing => anyhow::bail!(
                "could not join the ROS graph: this program has no {missing:?}; build it with \
                 --features {}",
                format!("{missing:?}").to_lowercase()
            ),
        }
    }

    /// Returns true if a peer may see the bridge without its endpoints, until it joins again.
    pub(crate) fn must_rejoin(&mut self) -> bool {
        on_each!(self, node => node.must_rejoin())
    }

    /// Opens a writer of a topic with an absolute name.
    ///
    /// # Errors
    /// The name is invalid, or the middleware fails.
    pub(crate) fn publisher<M: Message>(
        &mut self,
        topic: &str,
        quality: Quality,
    ) -> anyhow::Result<Box<dyn Publish<M>>> {
        on_each!(self, node => node.publisher(topic, quality))
    }

    /// Opens a reader of a topic with an absolute name.
    ///
    /// # Errors
    /// The name is invalid, or the middleware fails.
    pub(crate) fn subscription<M: Message>(
        &mut self,
        topic: &str,
        quality: Quality,
    ) -> anyhow::Result<Box<dyn Subscribe<M>>> {
        on_each!(self, node => node.subscription(topic, quality))
    }

    /// Opens a server of a service with an absolute name.
    ///
    /// # Errors
    /// The name is invalid, or the middleware fails.
    pub(crate) fn server<S: Service>(&mut self, name: &str) -> anyhow::Result<Box<dyn Serve<S>>>
    where
        S::Request: Carried,
        S::Response: Carried,
    {
        on_each!(self, node => node.server::<S>(name))
    }

    /// Opens the services and topics of an action with an absolute name.
    ///
    /// # Errors
    /// The name is invalid, or the middleware fails.
    pub(crate) fn action<A: Action>(
        &mut self,
        name: &str,
    ) -> anyhow::Result<Box<dyn ActionPorts<A>>> {
        on_each!(self, node => node.action::<A>(name))
    }
}

/// Message that every compiled middleware carries in services.
#[cfg(feature = "dds")]
pub(crate) trait Carried: Message + ros2_client::Message {}
#[cfg(feature = "dds")]
impl<M: Message + ros2_client::Message> Carried for M {}
/// Message that every compiled middleware carries in services.
#[cfg(not(feature = "dds"))]
pub(crate) trait Carried: Message {}
#[cfg(not(feature = "dds"))]
impl<M: Message> Carried for M {}
