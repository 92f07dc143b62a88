//! Control requests: one reply each, sent after the request took effect.

use std::time::{Duration, Instant};

use atas_core::OperatorRequest;
use atas_core::settings::{PARAMETERS, Parameter, present_name};
use shm_bus::{Bus, BusError, ControlCall, ControlServer, now_ns};
use shm_schemas::{
    ControlOp, ControlOutcome, ControlReply, ControlRequest, Hand, Mode, Reason, Stamp,
    StatusFlags, Text,
};

use super::SupervisorState;
use crate::link::SupervisorSide;

const REQUESTS_PER_ROUND: usize = 16;
/// Time limit for a tick to execute a request. Ticks stop only in lock-step without a simulator, or
/// after a failure.
const EXECUTION_TIMEOUT: Duration = Duration::from_secs(1);

#[derive(Debug)]
pub(super) struct ControlService {
    server: ControlServer,
    pending: Vec<PendingRequest>,
}

#[derive(Debug)]
struct PendingRequest {
    ticket: u64,
    call: ControlCall,
    reply: ControlReply,
    since: Instant,
}

enum Answer {
    Now(ControlReply),
    After(u64, ControlReply),
}

impl ControlService {
    pub(super) fn open(bus: &Bus) -> Result<Self, BusError> {
        Ok(Self {
            server: bus.control_server()?,
            pending: Vec::new(),
        })
    }

    pub(super) fn serve(&mut self, state: &mut SupervisorState, link: &mut SupervisorSide) {
        for _ in 0..REQUESTS_PER_ROUND {
            let call = match self.server.poll() {
                Ok(Some(call)) => call,
                Ok(None) => break,
                Err(error) => {
                    tracing::warn!(%error, "could not read a control request");
                    break;
                }
            };
            let request = *call.request();
            tracing::debug!(op = %request.op, name = %request.name, value = request.value, "control request");
            match answer(&request, state, link) {
                Answer::Now(reply) => send(call, reply),
                Answer::After(ticket, reply) => {
                    self.pending.push(PendingRequest {
                        ticket,
                        call,
                        reply,
                        since: Instant::now(),
                    });
                }
            }
        }
        self.reject_expired();
    }

    pub(super) fn complete(&mut self, ticket: u64) {
        for waiting in self.pending.extract_if(.., |w| w.ticket == ticket) {
            send(waiting.call, waiting.reply);
        }
    }

    fn reject_expired(&mut self) {
        for waiting in self
            .pending
            .extract_if(.., |w| w.since.elapsed() > EXECUTION_TIMEOUT)
        {
            let why = "queued, but no tick has executed it within 1 s; in lock-step, check that \
                the simulator runs";
            send(waiting.call, refused(why));
        }
    }
}

fn send(call: ControlCall, mut reply: ControlReply) {
    reply.stamp = Stamp {
        captured_ns: now_ns(),
        ..Stamp::default()
    };
    // A client that has gone needs no answer.
    let _heard = call.reply(&reply);
}

/// Executes a control request without a bus; returns its reply if it is known before the next tick.
pub fn execute_control(
    request: &ControlRequest,
    state: &mut SupervisorState,
    link: &mut SupervisorSide,
) -> Option<ControlReply> {
    match answer(request, state, link) {
        Answer::Now(reply) => Some(reply),
        Answer::After(..) => None,
    }
}

fn answer(
    request: &ControlRequest,
    state: &mut SupervisorState,
    link: &mut SupervisorSide,
) -> Answer {
    let ordered = match request.op {
        ControlOp::ESTOP => queue_request(OperatorRequest::Stop(Reason::Estop), link),
        ControlOp::RECOVER => recover(state, link),
        ControlOp::PARAM_GET => return Answer::Now(get(request, state)),
        ControlOp::PARAM_LIST => return Answer::Now(list(request, state)),
        ControlOp::PARAM_SET => return set(request, state, link),
        ControlOp::BIAS => bias(request, state, link),
        ControlOp::CANCEL => cancel(request, link),
        ControlOp::RELOAD => state.reload(link),
        ControlOp::ADVANCE => return Answer::Now(advance(request, state, link)),
        unknown => return Answer::Now(unknown_op(unknown)),
    };
    match ordered {
        Ok(ticket) => Answer::After(ticket, done()),
        Err(why) => Answer::Now(refused(&why)),
    }
}

/// Allows virtual time to advance. The reply comes at once; the simulator sets the pace.
fn advance(
    request: &ControlRequest,
    state: &SupervisorState,
    link: &SupervisorSide,
) -> ControlReply {
    /// Largest range in which every whole number is an exact `f64`.
    const TICKS_MAX: f64 = (1_u64 << 53) as f64;
    if state.flags & StatusFlags::LOCKSTEP == 0 {
        return refused(
            "could not advance: the daemon follows the clock and has no virtual time; start it \
             with --lockstep",
        );
    }
    if !(0.0..=TICKS_MAX).contains(&request.value) {
        return refused(&format!(
            "could not advance to tick {}: needs a number of ticks since the start, 0 to 2^53",
            request.value
        ));
    }
    link.advance_to(request.value as u64);
    done()
}

fn cancel(request: &ControlRequest, link: &mut SupervisorSide) -> Result<u64, String> {
    let name = request.name.as_str();
    let goal_id = name
        .parse()
        .map_err(|_| format!("could not cancel {name:?}: needs the id of a goal in decimal"))?;
    queue_request(OperatorRequest::Cancel { goal_id }, link)
}

fn queue_request(order: OperatorRequest, link: &mut SupervisorSide) -> Result<u64, String> {
    link.request(order)
        .ok_or_else(|| "the queue of requests is full; try again".to_owned())
}

fn recover(state: &SupervisorState, link: &mut SupervisorSide) -> Result<u64, String> {
    match state.mode {
        Mode::SAFE_STOP => queue_request(OperatorRequest::Recover, link),
        Mode::FAULT => Err("could not recover: the daemon itself failed; restart it".to_owned()),
        mode => Err(format!(
            "could not recover: the mode is {mode} and only safe-stop needs a recovery; nothing to \
             do"
        )),
    }
}

fn bias(
    request: &ControlRequest,
    state: &SupervisorState,
    link: &mut SupervisorSide,
) -> Result<u64, String> {
    let Some(hand) = (0..Hand::BOTH.len()).find(|hand| *hand as f64 == request.value) else {
        return Err(format!(
            "could not take the bias of hand {}: needs 0 (left) or 1 (right)",
            request.value
        ));
    };
    if !state.sensor_setup.joints_required {
        return Err(
            "could not take the bias: this daemon only senses (robot.joints_required is false), \
             and zeroing needs mode ready, thus a robot; restart the sensor process with --zero"
                .to_owned(),
        );
    }
    if state.mode != Mode::READY {
        return Err(format!(
            "could not take the bias: the mode is {} and must be ready with an empty hand; release \
             the object",
            state.mode
        ));
    }
    queue_request(OperatorRequest::Bias { hand }, link)
}

fn get(request: &ControlRequest, state: &SupervisorState) -> ControlReply {
    match find(request) {
        Ok((_, parameter)) => describe(parameter, state),
        Err(why) => unknown(&why),
    }
}

fn list(request: &ControlRequest, state: &SupervisorState) -> ControlReply {
    let parameter = PARAMETERS
        .iter()
        .enumerate()
        .find(|(index, _)| *index as f64 == request.value);
    match parameter {
        Some((_, parameter)) => describe(parameter, state),
        None => unknown(&format!(
            "parameters have the indices 0 to {}",
            PARAMETERS.len() - 1
        )),
    }
}

fn set(request: &ControlRequest, state: &mut SupervisorState, link: &mut SupervisorSide) -> Answer {
    let (index, parameter) = match find(request) {
        Ok(found) => found,
        Err(why) => return Answer::Now(unknown(&why)),
    };
    if parameter.is_safety() && !state.is_stopped() {
        let why = format!(
            "could not set {}: the mode is {}, but the change needs a stopped robot; run `atas estop` \
             before and `atas recover` after",
            parameter.name, state.mode
        );
        return Answer::Now(ControlReply {
            outcome: ControlOutcome::REFUSED,
            text: Text::new(&why),
            ..describe(parameter, state)
        });
    }
    match state.set_parameter(index, request.value, link) {
        Ok(ticket) => Answer::After(ticket, describe(parameter, state)),
        Err(why) => {
            let reply = describe(parameter, state);
            Answer::Now(ControlReply {
                outcome: ControlOutcome::REFUSED,
                text: Text::new(&why),
                ..reply
            })
        }
    }
}

fn find(request: &ControlRequest) -> Result<(usize, &'static Parameter), String> {
    let name = request.name.as_str();
    let found = PARAMETERS
        .iter()
        .enumerate()
        .find(|(_, parameter)| parameter.name == name);
    found.ok_or_else(|| match crate::config::suggested_parameter(name) {
        Some(now) if present_name(name) == Some(now) => {
            format!("{name} was renamed to {now}; use the new name")
        }
        Some(meant) => format!("no parameter has the name {name:?}; did you mean {meant}?"),
        None => format!("no parameter has the name {name:?}; `atas param list` shows them all"),
    })
}

fn describe(parameter: &Parameter, state: &SupervisorState) -> ControlReply {
    ControlReply {
        outcome: ControlOutcome::DONE,
        value: (parameter.get)(&state.config.settings()),
        lower: parameter.lower,
        upper: parameter.upper,
        text: Text::new(&format!("{}\n{}", parameter.name, parameter.doc.trim())),
        ..ControlReply::default()
    }
}

fn done() -> ControlReply {
    ControlReply {
        outcome: ControlOutcome::DONE,
        ..ControlReply::default()
    }
}

fn refused(why: &str) -> ControlReply {
    ControlReply {
        outcome: ControlOutcome::REFUSED,
        text: Text::new(why),
        ..ControlReply::default()
    }
}

fn unknown(why: &str) -> ControlReply {
    ControlReply {
        outcome: ControlOutcome::UNKNOWN,
        text: Text::new(why),
        ..ControlReply::default()
    }
}

fn unknown_op(op: ControlOp) -> ControlReply {
    unknown(&format!(
        "could not execute operation {}: this daemon does not know it; update the daemon",
        op.0
    ))
}
