//! Control requests: stop, recover, parameters.

use std::time::Duration;

use serde_json::json;
use shm_bus::BusName;
use shm_schemas::{ControlOp, ControlOutcome, ControlReply, ControlRequest, Text};

use super::Session;
use crate::exit::{Ended, Exit};
use crate::output::{Output, table};

/// How long the daemon may take to answer (ours: it looks 50 times a second).
const ANSWER: Duration = Duration::from_millis(900);

impl Session {
    /// Asks once and waits for the answer, whatever it is.
    fn ask(&self, op: ControlOp, value: f64, name: &str) -> anyhow::Result<ControlReply> {
        let request = ControlRequest {
            stamp: self.stamp(),
            op,
            value,
            name: Text::new(name),
            ..ControlRequest::default()
        };
        Ok(self.bus().control_client()?.call(&request, ANSWER)?)
    }

    /// Asks for something that must be done.
    fn demand(&self, op: ControlOp, value: f64, name: &str) -> anyhow::Result<ControlReply> {
        let reply = self.ask(op, value, name)?;
        match reply.outcome {
            ControlOutcome::DONE => Ok(reply),
            outcome => Err(Ended::with(
                Exit::Refused,
                format!("{outcome}: {}", reply.text),
            )),
        }
    }
}

/// `atas estop`.
pub(crate) fn estop(bus: &BusName, output: &mut Output) -> anyhow::Result<()> {
    act(
        bus,
        ControlOp::ESTOP,
        "stopped; `atas recover` re-arms",
        output,
    )
}

/// `atas recover`.
pub(crate) fn recover(bus: &BusName, output: &mut Output) -> anyhow::Result<()> {
    act(bus, ControlOp::RECOVER, "recovered", output)
}

fn act(bus: &BusName, op: ControlOp, done: &str, output: &mut Output) -> anyhow::Result<()> {
    let reply = Session::join(bus)?.demand(op, 0.0, "")?;
    if output.is_json() {
        output.json(&json!({ "op": op.name(), "outcome": reply.outcome.name() }))
    } else {
        output.line(done)
    }
}

/// `atas param list`.
pub(crate) fn list(bus: &BusName, output: &mut Output) -> anyhow::Result<()> {
    let session = Session::join(bus)?;
    let mut rows = table(&["parameter", "value", "from", "to", "meaning"]);
    for index in 0_u32.. {
        let reply = session.ask(ControlOp::PARAM_LIST, f64::from(index), "")?;
        if reply.outcome != ControlOutcome::DONE {
            break;
        }
        let name = reply.text.as_str();
        if output.is_json() {
            output.json(&parameter(name, &reply))?;
        } else {
            rows.add_row([
                name.to_owned(),
                reply.value.to_string(),
                reply.lower.to_string(),
                reply.upper.to_string(),
                meaning(name).to_owned(),
            ]);
        }
    }
    if output.is_json() {
        return Ok(());
    }
    output.line(rows)
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
    let reply = Session::join(bus)?.demand(op, value, name)?;
    if output.is_json() {
        return output.json(&parameter(name, &reply));
    }
    let ControlReply {
        value,
        lower,
        upper,
        ..
    } = reply;
    output.line(format!("{name} = {value} (from {lower} to {upper})"))
}

fn parameter(name: &str, reply: &ControlReply) -> serde_json::Value {
    json!({
        "name": name,
        "value": reply.value,
        "lower": reply.lower,
        "upper": reply.upper,
        "meaning": meaning(name),
    })
}

/// What a parameter means, as this version knows it; the daemon's protocol carries numbers only.
fn meaning(name: &str) -> &'static str {
    atas_core::settings::find(name).map_or("", |parameter| parameter.doc.trim())
}
