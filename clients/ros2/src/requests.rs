//! Services: stop, recovery, zero.
//!
//! The stop has a thread and a bus connection of its own, and uses the stop socket first.

use std::time::Duration;

use atas_client::request_stop;
use shm_bus::BusName;
use shm_schemas::{ControlOp, Hand, StopOutcome};

use crate::link::BusLink;
use crate::middleware::{Node, Serve};
use crate::wire::standard::{Trigger, TriggerResponse};

/// Poll interval of the stop. Design choice: two ticks.
const STOP_POLL: Duration = Duration::from_millis(2);
/// Longest time until the daemon acknowledges a stop (design choice: normally one tick).
const STOP_REPLY: Duration = Duration::from_millis(800);

/// Server of the stop.
pub(crate) struct StopService(Box<dyn Serve<Trigger>>);

impl StopService {
    /// Opens the service.
    ///
    /// # Errors
    /// The middleware fails.
    pub(crate) fn open(node: &mut Node, namespace: &str) -> anyhow::Result<Self> {
        Ok(Self(node.server(&format!("{namespace}/stop"))?))
    }

    /// Serves until `is_over`.
    pub(crate) fn run(&mut self, bus: &BusName, is_over: impl Fn() -> bool) {
        while !is_over() {
            answer(&mut self.0, || stop_robot(bus));
            std::thread::sleep(STOP_POLL);
        }
    }
}

fn stop_robot(bus: &BusName) -> Result<String, String> {
    let reply = request_stop(bus, "a ROS 2 client", STOP_REPLY)
        .map_err(|error| format!("the robot may move on: {error}"))?;
    if reply.outcome == StopOutcome::STOPPED {
        Ok(format!("stopped over the {} channel", reply.channel.name()))
    } else {
        Err(format!(
            "the daemon answered {}; use the emergency stop",
            reply.outcome
        ))
    }
}

/// Servers of recovery and zero.
pub(crate) struct ControlServices {
    recover: Box<dyn Serve<Trigger>>,
    zero: [Box<dyn Serve<Trigger>>; 2],
}

impl ControlServices {
    /// Opens the services.
    ///
    /// # Errors
    /// The middleware fails.
    pub(crate) fn open(node: &mut Node, namespace: &str) -> anyhow::Result<Self> {
        let [left, right] = Hand::BOTH;
        Ok(Self {
            recover: node.server(&format!("{namespace}/recover"))?,
            zero: [
                node.server(&format!("{namespace}/{left}/zero"))?,
                node.server(&format!("{namespace}/{right}/zero"))?,
            ],
        })
    }

    /// Answers all requests.
    pub(crate) fn poll(&mut self, link: &mut BusLink) {
        answer(&mut self.recover, || request(link, ControlOp::RECOVER, 0.0));
        for (index, service) in (0_u8..).zip(&mut self.zero) {
            answer(service, || request(link, ControlOp::BIAS, f64::from(index)));
        }
    }
}

fn request(link: &mut BusLink, op: ControlOp, value: f64) -> Result<String, String> {
    let session = link.session().map_err(|error| error.to_string())?;
    let reply = session.request_success(op, value, "");
    if matches!(reply, Err(atas_client::ClientError::Bus(_))) {
        // A new daemon may use a new bus.
        link.close();
    }
    reply
        .map(|reply| reply.text.to_string())
        .map_err(|error| error.to_string())
}

/// Answers the next request of a service with the result of `act`.
fn answer(service: &mut Box<dyn Serve<Trigger>>, mut act: impl FnMut() -> Result<String, String>) {
    let done = service.take().and_then(|request| {
        let Some((caller, _)) = request else {
            return Ok(());
        };
        let (success, message) = match act() {
            Ok(message) => (true, message),
            Err(cause) => (false, cause),
        };
        service.respond(caller, TriggerResponse { success, message })
    });
    if let Err(error) = done {
        tracing::warn!("service: {error:#}");
    }
}
