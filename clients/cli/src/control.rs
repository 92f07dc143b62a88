//! Control requests: recover, cancel, zero, parameters.

use std::time::{Duration, Instant};

use atas_client::{ClientError, POLL, Session};
use atas_console::arguments::Zero;
use atas_console::{Exit, ExitError, Output, table};
use serde_json::json;
use shm_bus::BusName;
use shm_schemas::{ControlOp, ControlOutcome, ControlReply, Hand};

/// Longest wait for the end of a cancelled goal. Design choice: 50 status periods.
const CANCEL_TIMEOUT: Duration = Duration::from_secs(1);

pub(crate) fn recover(bus: &BusName, output: &mut Output) -> anyhow::Result<()> {
    request(bus, (ControlOp::RECOVER, 0.0), "recovered", output)
}

pub(crate) fn zero(arguments: &Zero, output: &mut Output) -> anyhow::Result<()> {
    let hand = Hand::from(arguments.hand);
    let op = (ControlOp::BIAS, f64::from(hand.0));
    let done = format!("zeroed the fingertip sensors of the {hand} hand");
    request(&arguments.bus.bus, op, &done, output)
}

/// `atas cancel`: cancels the active goal of any client.
pub(crate) fn cancel(bus: &BusName, output: &mut Output) -> anyhow::Result<()> {
    let session = Session::existing(bus)?;
    let (mut statuses, mut status) = session.watch_status()?;
    let goal_id = status.goal_id;
    if goal_id == 0 || status.goal_state.is_final() {
        return Err(ExitError::with_code(Exit::Refused, "no goal to cancel"));
    }
    session.request_success(ControlOp::CANCEL, 0.0, &goal_id.to_string())?;
    let begin = Instant::now();
    while status.goal_id == goal_id && !status.goal_state.is_final() {
        if begin.elapsed() > CANCEL_TIMEOUT {
            return Err(ClientError::Unconfirmed(CANCEL_TIMEOUT).into());
        }
        std::thread::sleep(POLL);
        statuses.newest(&mut status)?;
    }
    if output.is_json() {
        return output.json(&json!({ "op": "cancel", "goal_id": goal_id, "outcome": "done" }));
    }
    output.line("cancelled; the hands stay in place and keep their grip")
}

fn request(
    bus: &BusName,
    (op, value): (ControlOp, f64),
    done: &str,
    output: &mut Output,
) -> anyhow::Result<()> {
    let reply = Session::existing(bus)?.request_success(op, value, "")?;
    if output.is_json() {
        output.json(&json!({ "op": op.name(), "outcome": reply.outcome.name() }))
    } else {
        output.line(done)
    }
}

pub(crate) fn list(bus: &BusName, output: &mut Output) -> anyhow::Result<()> {
    let session = Session::existing(bus)?;
    let mut rows = table(&["parameter", "value", "from", "to", "meaning"]);
    for index in 0_u32.. {
        let reply = session.request(ControlOp::PARAM_LIST, f64::from(index), "")?;
        if reply.outcome != ControlOutcome::DONE {
            break;
        }
        let (name, meaning) = name_and_meaning(&reply);
        if output.is_json() {
            output.json(&parameter_json(&reply))?;
        } else {
            rows.add_row([
                name.to_owned(),
                reply.value.to_string(),
                reply.lower.to_string(),
                reply.upper.to_string(),
                meaning.to_owned(),
            ]);
        }
    }
    if output.is_json() {
        return Ok(());
    }
    output.table(rows)
}

pub(crate) fn get(bus: &BusName, name: &str, output: &mut Output) -> anyhow::Result<()> {
    show(bus, ControlOp::PARAM_GET, name, 0.0, output)
}

pub(crate) fn set(
    bus: &BusName,
    name: &str,
    value: f64,
    output: &mut Output,
) -> anyhow::Result<()> {
    show(bus, ControlOp::PARAM_SET, name, value, output)
}

fn show(
    bus: &BusName,
    op: ControlOp,
    name: &str,
    value: f64,
    output: &mut Output,
) -> anyhow::Result<()> {
    let reply = Session::existing(bus)?.request_success(op, value, name)?;
    if output.is_json() {
        return output.json(&parameter_json(&reply));
    }
    let ControlReply {
        value,
        lower,
        upper,
        ..
    } = reply;
    output.line(format!("{name} = {value} (from {lower} to {upper})"))
}

fn parameter_json(reply: &ControlReply) -> serde_json::Value {
    let (name, meaning) = name_and_meaning(reply);
    json!({
        "name": name,
        "value": reply.value,
        "lower": reply.lower,
        "upper": reply.upper,
        "meaning": meaning,
    })
}

/// Splits the reply text into name and meaning of a parameter.
fn name_and_meaning(reply: &ControlReply) -> (&str, &str) {
    let text = reply.text.as_str();
    text.split_once('\n').unwrap_or((text, ""))
}
