//! Parameters of the daemon over its control service.

use atas_client::{ClientError, Session};
use shm_schemas::{ControlOp, ControlOutcome, ControlReply};

use super::NAMES_MAX;
use crate::link::BusLink;
use crate::wire::parameters::{Parameter, ParameterValue, kind};

/// Longest name, bytes: that of a control request.
const NAME_MAX: usize = 63;

/// Known parameter of the daemon.
pub(super) struct Known {
    pub(super) name: String,
    pub(super) meaning: String,
    pub(super) reply: ControlReply,
}

fn number(double_value: f64) -> ParameterValue {
    ParameterValue {
        r#type: kind::DOUBLE,
        double_value,
        ..ParameterValue::default()
    }
}

fn call(
    link: &mut BusLink,
    op: ControlOp,
    value: f64,
    name: &str,
) -> Result<ControlReply, ClientError> {
    let reply = link
        .session()
        .and_then(|session: &Session| session.request(op, value, name));
    if matches!(reply, Err(ClientError::Bus(_))) {
        // A new daemon may use a new bus.
        link.close();
    }
    reply
}

/// Returns the value of a parameter; no value if it is unknown or no daemon answers.
pub(super) fn value(link: &mut BusLink, name: &str) -> ParameterValue {
    if name.len() > NAME_MAX {
        return ParameterValue::default();
    }
    match call(link, ControlOp::PARAM_GET, 0.0, name) {
        Ok(reply) if reply.outcome == ControlOutcome::DONE => number(reply.value),
        _ => ParameterValue::default(),
    }
}

pub(super) fn set(link: &mut BusLink, parameter: &Parameter) -> Result<(), String> {
    let name: String = parameter.name.chars().take(NAME_MAX).collect();
    let of = &parameter.value;
    if of.r#type != kind::DOUBLE || !of.double_value.is_finite() {
        return Err(format!(
            "{name} needs a finite floating-point number, for example 0.08"
        ));
    }
    if parameter.name.len() > NAME_MAX {
        return Err(format!(
            "{name}…: a parameter name has at most {NAME_MAX} bytes"
        ));
    }
    let reply = call(link, ControlOp::PARAM_SET, of.double_value, &name);
    let reply = reply.map_err(|error| error.to_string())?;
    if reply.outcome == ControlOutcome::DONE {
        return Ok(());
    }
    Err(format!("{}: {}", reply.outcome, reply.text))
}

/// Returns all parameters of the daemon; none if it does not answer.
pub(super) fn all(link: &mut BusLink) -> Vec<Known> {
    let mut known = Vec::new();
    for index in 0..NAMES_MAX as u32 {
        let Ok(reply) = call(link, ControlOp::PARAM_LIST, f64::from(index), "") else {
            break;
        };
        if reply.outcome != ControlOutcome::DONE {
            break;
        }
        let text = reply.text.as_str();
        let (name, meaning) = text.split_once('\n').unwrap_or((text, ""));
        known.push(Known {
            name: name.to_owned(),
            meaning: meaning.to_owned(),
            reply,
        });
    }
    known
}
