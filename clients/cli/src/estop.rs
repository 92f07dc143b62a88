//! `atas estop`: on the way that nothing else can occupy.
//!
//! No bus is joined, no lock taken, nothing cleaned up first ([`shm_bus::stop`]).

use std::time::Duration;

use atas_console::Output;
use serde_json::json;
use shm_bus::{BusName, stop};
use shm_schemas::{ControlOp, StopOutcome};

/// How long the daemon may take to answer. Ours: an answer takes one tick, and twenty milliseconds without one.
const ANSWER: Duration = Duration::from_millis(800);

/// Stops the robot, and says whether a tick took it.
pub(crate) fn estop(bus: &BusName, output: &mut Output) -> anyhow::Result<()> {
    let outcome = stop::request(bus, "atas estop", ANSWER)?.outcome;
    if output.is_json() {
        return output.json(&json!({
            "op": ControlOp::ESTOP.name(),
            "outcome": "done",
            "stop": outcome.name(),
        }));
    }
    output.line(sentence(outcome))
}

/// What a user reads.
fn sentence(outcome: StopOutcome) -> &'static str {
    if outcome == StopOutcome::STOPPED {
        "stopped; `atas recover` re-arms"
    } else {
        "the daemon has the stop, but no tick has come since; it stops with its next tick (in lock-step, with the next \
         frame). See `atas status`"
    }
}
