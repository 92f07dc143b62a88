//! Control requests: recover, cancel, zero, parameters.

use std::time::{Duration, Instant};

use atas_client::{ClientError, POLL, Session};
use atas_console::arguments::Zero;
use atas_console::{Ended, Exit, Output, table};
use serde_json::json;
use shm_bus::BusName;
use shm_schemas::{ControlOp, ControlOutcome, ControlReply, Hand};

/// How long the end of a cancelled goal may take (ours: fifty statuses).
const CONFIRMATION: Duration = Duration::from_secs(1);

/// `atas recover`.
pub(crate) fn recover(bus: &BusName, output: &mut Output) -> anyhow::Result<()> {
    act(bus, (ControlOp::RECOVER, 0.0), "recovered", output)
}

/// `atas zero`.
pub(crate) fn zero(arguments: &Zero, output: &mut Output) -> anyhow::Result<()> {
    let hand = Hand::from(arguments.hand);
    let op = (ControlOp::BIAS, f64::from(hand.0));
    let done = format!("what the {hand} hand feels now is its zero");
    act(&arguments.bus.bus, op, &done, output)
}

/// `atas cancel`: the active goal, whoever sent it.
pub(crate) fn cancel(bus: &BusName, output: &mut Output) -> anyhow::Result<()> {
    let session = Session::existing(bus)?;
    let (mut statuses, mut status) = session.watch_status()?;
    let goal_id = status.goal_id;
    if goal_id == 0 || status.goal_state.is_final() {
        return Err(Ended::with(Exit::Refused, "there is no goal to cancel"));
    }
    session.demand(ControlOp::CANCEL, 0.0, &goal_id.to_string())?;
    let begin = Instant::now();
    while status.goal_id == goal_id && !status.goal_state.is_final() {
        if begin.elapsed() > CONFIRMATION {
            return Err(ClientError::Unconfirmed(CONFIRMATION).into());
        }
        std::thread::sleep(POLL);
        statuses.newest(&mut status)?;
    }
    if output.is_json() {
        return output.json(&json!({ "op": "cancel", "goal_id": goal_id, "outcome": "done" }));
    }
    output.line("cancelled; the hands stay where they are and keep what they hold")
}

fn act(
    bus: &BusName,
    (op, value): (ControlOp, f64),
    done: &str,
    output: &mut Output,
) -> anyhow::Result<()> {
    let reply = Session::existing(bus)?.demand(op, value, "")?;
    if output.is_json() {
        output.json(&json!({ "op": op.name(), "outcome": reply.outcome.name() }))
    } else {
        output.line(done)
    }
}

/// `atas param list`.
pub(crate) fn list(bus: &BusName, output: &mut Output) -> anyhow::Result<()> {
    let session = Session::existing(bus)?;
    let mut rows = table(&["parameter", "value", "from", "to", "meaning"]);
    for index in 0_u32.. {
        let reply = session.ask(ControlOp::PARAM_LIST, f64::from(index), "")?;
        if reply.outcome != ControlOutcome::DONE {
            break;
        }
        let (name, meaning) = described(&reply);
        if output.is_json() {
            output.json(&parameter(&reply))?;
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

/// `atas param get`.
pub(crate) fn get(bus: &BusName, name: &str, output: &mut Output) -> anyhow::Result<()> {
    show(bus, ControlOp::PARAM_GET, name, 0.0, output)
}

/// `atas param set`.
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
    let reply = Session::existing(bus)?.demand(op, value, name)?;
    if output.is_json() {
        return output.json(&parameter(&reply));
    }
    let ControlReply {
        value,
        lower,
        upper,
        ..
    } = reply;
    output.line(format!("{name} = {value} (from {lower} to {upper})"))
}

fn parameter(reply: &ControlReply) -> serde_json::Value {
    let (name, meaning) = described(reply);
    json!({
        "name": name,
        "value": reply.value,
        "lower": reply.lower,
        "upper": reply.upper,
        "meaning": meaning,
    })
}

/// Name and meaning of a parameter, as the daemon tells them.
fn described(reply: &ControlReply) -> (&str, &str) {
    let text = reply.text.as_str();
    text.split_once('\n').unwrap_or((text, ""))
}
