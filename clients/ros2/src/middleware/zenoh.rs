//! Node over Zenoh (`hiroz`), as rmw_zenoh nodes: type hashes are part of every key.

use std::fmt::Display;
use std::num::NonZeroUsize;

use anyhow::anyhow;
use hiroz::Builder;
use hiroz::context::{ZContext, ZContextBuilder};
use hiroz::entity::{TypeHash, TypeInfo};
use hiroz::msg::{SerdeCdrSerdes, ZMessage, ZService};
use hiroz::node::ZNode;
use hiroz::pubsub::{ZPub, ZSub};
use hiroz::qos::{QosDurability, QosHistory, QosProfile, QosReliability};
use hiroz::service::{ServiceReply, ZServer};
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

use super::requests::Waiting;
use super::{ActionPorts, Caller, NodeOptions, Publish, Quality, Serve, Subscribe};
use crate::wire::action::{
    FeedbackMessage, GetResult, GetResultRequest, GetResultResponse, SendGoal, SendGoalRequest,
    SendGoalResponse,
};
use crate::wire::standard::{CancelGoal, CancelGoalRequest, CancelGoalResponse, GoalStatusArray};
use crate::wire::{Action, Message, Service, message_hash, service_hash};

/// Requests kept for a slow server. Design choice: requests of one poll interval.
const SERVICE_DEPTH: usize = 100;

/// Node over Zenoh.
pub(crate) struct ZenohNode {
    node: ZNode,
    _context: ZContext,
}

impl ZenohNode {
    pub(super) fn join(options: &NodeOptions) -> anyhow::Result<Self> {
        let router = &options.router;
        let context = ZContextBuilder::default()
            .with_router_endpoint(router.clone())
            .and_then(|builder| builder.with_domain_id(options.domain.into()).build())
            .map_err(|error| {
                anyhow!(
                    "could not reach a Zenoh router at {router}: {error}; start one, for example \
                     `ros2 run rmw_zenoh_cpp rmw_zenohd`, or give its address with --router"
                )
            })?;
        // The services of parameters are those of the bridge, as over DDS.
        let node = context
            .create_node(&options.name)
            .with_namespace(&options.namespace);
        let node = node.without_parameters().build();
        Ok(Self {
            node: node.map_err(|error| anyhow!("could not create the node: {error}"))?,
            _context: context,
        })
    }

    /// Returns false: the router restores all keys.
    #[expect(clippy::unused_self, reason = "as over DDS")]
    pub(super) fn must_rejoin(&mut self) -> bool {
        false
    }

    pub(super) fn publisher<M: Message>(
        &mut self,
        topic: &str,
        quality: Quality,
    ) -> anyhow::Result<Box<dyn Publish<M>>> {
        let of = info(&M::type_name(), &message_hash::<M>())?;
        let builder = self.node.create_pub_impl::<Wire<M>>(topic, Some(of));
        let publisher = builder.with_qos(profile(quality)).build();
        Ok(Box::new(publisher.map_err(|error| failure(topic, error))?))
    }

    pub(super) fn subscription<M: Message>(
        &mut self,
        topic: &str,
        quality: Quality,
    ) -> anyhow::Result<Box<dyn Subscribe<M>>> {
        let of = info(&M::type_name(), &message_hash::<M>())?;
        let builder = self.node.create_sub_impl::<Wire<M>>(topic, Some(of));
        let reader = builder.with_qos(profile(quality)).build();
        Ok(Box::new(reader.map_err(|error| failure(topic, error))?))
    }

    pub(super) fn server<S: Service>(&mut self, name: &str) -> anyhow::Result<Box<dyn Serve<S>>> {
        Ok(Box::new(self.typed_server::<S>(name)?))
    }

    fn typed_server<S: Service>(&mut self, name: &str) -> anyhow::Result<ZenohServer<S>> {
        let of = info(&S::type_name(), &service_hash::<S>())?;
        let builder = self.node.create_service_impl::<Pair<S>>(name, Some(of));
        let depth = Quality {
            depth: SERVICE_DEPTH,
            ..Quality::STREAM
        };
        let server = builder.with_qos(profile(depth)).build();
        Ok(ZenohServer {
            server: server.map_err(|error| failure(name, error))?,
            waiting: Waiting::default(),
        })
    }

    pub(super) fn action<A: Action>(
        &mut self,
        name: &str,
    ) -> anyhow::Result<Box<dyn ActionPorts<A>>> {
        let of = |part: &str| format!("{name}/_action/{part}");
        Ok(Box::new(ZenohAction::<A> {
            goals: self.typed_server(&of("send_goal"))?,
            cancels: self.typed_server(&of("cancel_goal"))?,
            results: self.typed_server(&of("get_result"))?,
            feedback: self.publisher(&of("feedback"), Quality::STREAM)?,
            statuses: self.publisher(&of("status"), Quality::LATCHED)?,
        }))
    }
}

/// Message as hiroz expects it: serialised by serde.
#[derive(Debug, Serialize, Deserialize)]
#[serde(transparent, bound = "M: Serialize + DeserializeOwned")]
struct Wire<M>(M);

impl<M: Message> ZMessage for Wire<M> {
    type Serdes = SerdeCdrSerdes<Self>;
}

/// Request and response of a service.
struct Pair<S>(std::marker::PhantomData<S>);

impl<S: Service> ZService for Pair<S> {
    type Request = Wire<S::Request>;
    type Response = Wire<S::Response>;
}

/// Returns name and hash of a type, for example `std_srvs::srv::dds_::Trigger_`.
fn info(type_name: &str, hash: &str) -> anyhow::Result<TypeInfo> {
    let mut parts: Vec<&str> = type_name.split('/').collect();
    let last = parts.pop().unwrap_or_default();
    let name = format!("{}::dds_::{last}_", parts.join("::"));
    let hash = TypeHash::from_rihs_string(hash);
    let hash = hash.ok_or_else(|| anyhow!("invalid type hash of {type_name}"))?;
    Ok(TypeInfo::new(&name, hash))
}

fn failure(name: &str, error: impl Display) -> anyhow::Error {
    anyhow!("could not open {name} over Zenoh: {error}")
}

fn profile(quality: Quality) -> QosProfile {
    QosProfile {
        reliability: if quality.reliable {
            QosReliability::Reliable
        } else {
            QosReliability::BestEffort
        },
        durability: if quality.latched {
            QosDurability::TransientLocal
        } else {
            QosDurability::Volatile
        },
        history: QosHistory::KeepLast(
            NonZeroUsize::new(quality.depth).unwrap_or(NonZeroUsize::MIN),
        ),
        ..QosProfile::default()
    }
}

impl<M: Message> Publish<M> for ZPub<Wire<M>, SerdeCdrSerdes<Wire<M>>> {
    fn publish(&self, message: M) -> anyhow::Result<()> {
        let sent = ZPub::publish(self, &Wire(message));
        sent.map_err(|error| anyhow!("could not publish: {error}"))
    }
}

impl<M: Message> Subscribe<M> for ZSub<Wire<M>, zenoh::sample::Sample, SerdeCdrSerdes<Wire<M>>> {
    fn take(&mut self) -> anyhow::Result<Option<M>> {
        if !self.is_ready() {
            return Ok(None);
        }
        let taken = self.recv();
        let taken = taken.map_err(|error| anyhow!("could not read a message: {error}"))?;
        Ok(Some(taken.0))
    }
}

struct ZenohServer<S: Service> {
    server: ZServer<Pair<S>>,
    waiting: Waiting<ServiceReply<Pair<S>>>,
}

impl<S: Service> Serve<S> for ZenohServer<S> {
    fn take(&mut self) -> anyhow::Result<Option<(Caller, S::Request)>> {
        let taken = self.server.try_take_request();
        let taken = taken.map_err(|error| anyhow!("could not read a request: {error}"))?;
        Ok(taken.map(|request| {
            let (message, reply) = request.into_parts();
            (self.waiting.add(reply), message.0)
        }))
    }

    fn respond(&mut self, to: Caller, response: S::Response) -> anyhow::Result<()> {
        let reply = self.waiting.remove(to)?;
        let sent = reply.reply_blocking(&Wire(response));
        sent.map_err(|error| anyhow!("could not answer a request: {error}"))
    }
}

struct ZenohAction<A: Action> {
    goals: ZenohServer<SendGoal<A>>,
    cancels: ZenohServer<CancelGoal>,
    results: ZenohServer<GetResult<A>>,
    feedback: Box<dyn Publish<FeedbackMessage<A>>>,
    statuses: Box<dyn Publish<GoalStatusArray>>,
}

impl<A: Action> ActionPorts<A> for ZenohAction<A> {
    fn take_goal(&mut self) -> anyhow::Result<Option<(Caller, SendGoalRequest<A>)>> {
        self.goals.take()
    }

    fn respond_goal(&mut self, to: Caller, response: SendGoalResponse<A>) -> anyhow::Result<()> {
        self.goals.respond(to, response)
    }

    fn take_cancel(&mut self) -> anyhow::Result<Option<(Caller, CancelGoalRequest)>> {
        self.cancels.take()
    }

    fn respond_cancel(&mut self, to: Caller, response: CancelGoalResponse) -> anyhow::Result<()> {
        self.cancels.respond(to, response)
    }

    fn take_result(&mut self) -> anyhow::Result<Option<(Caller, GetResultRequest<A>)>> {
        self.results.take()
    }

    fn respond_result(&mut self, to: Caller, response: GetResultResponse<A>) -> anyhow::Result<()> {
        self.results.respond(to, response)
    }

    fn feedback(&mut self, message: FeedbackMessage<A>) -> anyhow::Result<()> {
        self.feedback.publish(message)
    }

    fn statuses(&mut self, message: GoalStatusArray) -> anyhow::Result<()> {
        self.statuses.publish(message)
    }
}
