//! Servers of the gripper actions. A newer command replaces the running one.

use std::time::{Duration, Instant};

use atas_client::ClientError;
use shm_schemas::Hand;

use super::Journal;
use super::gripper::{Ended, Gripper};
use super::gripper_action::{Command, GripperAction, GripperState};
use super::scene::Scene;
use super::server::{ActionServer, Wanted};
use crate::link::BusLink;
use crate::middleware::Node;
use crate::wire::action::{GripperCommandAction, ParallelGripperAction, status};
use crate::wire::standard::Uuid;

/// Interval of progress messages.
const FEEDBACK: Duration = Duration::from_millis(100);

/// Request of a client.
enum Request {
    Start(Uuid, Result<Command, String>),
    Cancel(Uuid),
}

/// Server of one gripper action.
trait Port: Send {
    fn name(&self) -> &str;
    fn reopen(&mut self, node: &mut Node) -> anyhow::Result<()>;
    fn receive(&mut self) -> Vec<Request>;
    fn execute(&mut self, id: &Uuid);
    fn feedback(&mut self, id: &Uuid, state: &GripperState);
    fn finish(&mut self, id: &Uuid, status: i8, state: &GripperState);
}

impl<A: GripperAction> Port for ActionServer<A> {
    fn name(&self) -> &str {
        self.name()
    }

    fn reopen(&mut self, node: &mut Node) -> anyhow::Result<()> {
        self.reopen(node)
    }

    fn receive(&mut self) -> Vec<Request> {
        let wanted = self.poll().into_iter();
        let requests = wanted.map(|wanted| match wanted {
            Wanted::Goal(id, goal) => Request::Start(id, A::command(&goal)),
            Wanted::Cancel(id) => Request::Cancel(id),
        });
        requests.collect()
    }

    fn execute(&mut self, id: &Uuid) {
        self.execute(id);
    }

    fn feedback(&mut self, id: &Uuid, state: &GripperState) {
        self.feedback(id, A::feedback(state));
    }

    fn finish(&mut self, id: &Uuid, status: i8, state: &GripperState) {
        self.finish(id, status, &A::result(state));
    }
}

/// Goal that the gripper executes.
struct Current {
    port: usize,
    id: Uuid,
    reported: Instant,
}

/// Gripper actions of both hands.
pub(super) struct Grippers {
    gripper: Gripper,
    ports: Vec<(Hand, Box<dyn Port>)>,
    current: Option<Current>,
}

fn port<A: GripperAction>(
    node: &mut Node,
    namespace: &str,
    hand: Hand,
) -> anyhow::Result<(Hand, Box<dyn Port>)> {
    let name = format!("{namespace}/{hand}/{}", A::NAME);
    let server = ActionServer::<A>::new(&name, node.action(&name)?);
    Ok((hand, Box::new(server)))
}

impl Grippers {
    pub(super) fn open(node: &mut Node, namespace: &str) -> anyhow::Result<Self> {
        let mut ports = Vec::new();
        for hand in Hand::BOTH {
            ports.push(port::<GripperCommandAction>(node, namespace, hand)?);
            ports.push(port::<ParallelGripperAction>(node, namespace, hand)?);
        }
        Ok(Self {
            gripper: Gripper::default(),
            ports,
            current: None,
        })
    }

    /// Continues with another participant.
    pub(super) fn reopen(&mut self, node: &mut Node) -> anyhow::Result<()> {
        self.ports
            .iter_mut()
            .try_for_each(|(_, port)| port.reopen(node))
    }

    /// Returns true if no command runs.
    pub(super) fn is_idle(&self) -> bool {
        self.current.is_none()
    }

    /// Forgets the stream of a daemon that is gone.
    pub(super) fn forget(&mut self) {
        self.gripper.forget();
    }

    /// Ends an idle stream, because another goal begins; returns true if there is none.
    pub(super) fn make_way(&mut self) -> bool {
        self.gripper.make_way()
    }

    pub(super) fn poll(&mut self, link: &mut BusLink, scene: Option<&Scene>, journal: &Journal) {
        for port in 0..self.ports.len() {
            for request in self.ports[port].1.receive() {
                match request {
                    Request::Start(id, Ok(command)) => self.start(port, id, command, journal),
                    Request::Start(id, Err(cause)) => {
                        let state = self.state(self.ports[port].0, scene, cause);
                        self.finish(port, &id, status::ABORTED, &state, journal);
                    }
                    Request::Cancel(id) => self.cancel(port, &id),
                }
            }
        }
        let ended = match (link.session(), scene) {
            (Ok(session), Some(scene)) => self.gripper.poll(session, scene),
            (Err(error), _) => self.missing(&error),
            (Ok(_), None) => None,
        };
        match (ended, &self.current) {
            (Some(ended), Some(_)) => self.end(&ended, journal),
            (None, Some(_)) => self.report(scene),
            (_, None) => {}
        }
    }

    fn start(&mut self, port: usize, id: Uuid, command: Command, journal: &Journal) {
        if let Some(old) = self.current.take() {
            let state = GripperState {
                cause: "goal replaced by a newer one".to_owned(),
                ..GripperState::default()
            };
            self.finish(old.port, &old.id, status::ABORTED, &state, journal);
        }
        let (hand, server) = &mut self.ports[port];
        server.execute(&id);
        journal.write(server.name(), &id, status::EXECUTING, "", "");
        self.gripper.start(*hand, command);
        self.current = Some(Current {
            port,
            id,
            reported: Instant::now(),
        });
    }

    fn cancel(&mut self, port: usize, id: &Uuid) {
        let current = self.current.as_ref();
        if current.is_some_and(|current| current.port == port && current.id == *id) {
            self.gripper.cancel();
        }
    }

    fn missing(&mut self, error: &ClientError) -> Option<Ended> {
        self.gripper.forget();
        self.current.as_ref().map(|_| {
            Ended::Failed(GripperState {
                cause: format!("goal not sent: {error}"),
                ..GripperState::default()
            })
        })
    }

    fn state(&self, hand: Hand, scene: Option<&Scene>, cause: String) -> GripperState {
        let state = scene.map(|scene| self.gripper.state(hand, scene));
        GripperState {
            cause,
            ..state.unwrap_or_default()
        }
    }

    fn end(&mut self, ended: &Ended, journal: &Journal) {
        let Some(Current { port, id, .. }) = self.current.take() else {
            return;
        };
        let (status, state) = match ended {
            Ended::Done(state) => (status::SUCCEEDED, state),
            Ended::Failed(state) => (status::ABORTED, state),
            Ended::Cancelled(state) => (status::CANCELED, state),
        };
        self.finish(port, &id, status, state, journal);
    }

    fn finish(
        &mut self,
        port: usize,
        id: &Uuid,
        status: i8,
        state: &GripperState,
        journal: &Journal,
    ) {
        let server = &mut self.ports[port].1;
        server.finish(id, status, state);
        journal.write(server.name(), id, status, "", &state.cause);
    }

    fn report(&mut self, scene: Option<&Scene>) {
        let (Some(current), Some(scene)) = (&mut self.current, scene) else {
            return;
        };
        if current.reported.elapsed() < FEEDBACK {
            return;
        }
        current.reported = Instant::now();
        let (hand, server) = &mut self.ports[current.port];
        let state = self.gripper.state(*hand, scene);
        server.feedback(&current.id, &state);
    }
}
