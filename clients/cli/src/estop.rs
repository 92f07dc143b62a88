//! `atas estop`: on the way that nothing else can occupy.
//!
//! No bus is joined, no lock taken, nothing cleaned up first ([`shm_bus::stop`]).

use std::time::{Duration, Instant};

use atas_client::Stopped;
use atas_console::{Ended, Exit, Output};
use serde_json::json;
use shm_bus::{BusError, BusName, Owner, stop};
use shm_schemas::{ControlOp, StopAnswer, StopOutcome};

/// How long the daemon may take to answer. Ours: an answer takes one tick, and twenty milliseconds without one.
const ANSWER: Duration = Duration::from_millis(800);
/// How long a tick may take to come. Ours: a thousand of them.
const TAKEN_WITHIN: Duration = Duration::from_secs(1);
/// Pause before it is asked again whether one came: each question is a stop, and an event of the daemon's.
const ASK_AGAIN: Duration = Duration::from_millis(100);

/// Stops the robot. Done only if a tick took it.
pub(crate) fn estop(bus: &BusName, output: &mut Output) -> anyhow::Result<()> {
    let begin = Instant::now();
    loop {
        let answer = ask(bus)?;
        if answer.outcome == StopOutcome::STOPPED {
            return done(output);
        }
        if begin.elapsed() >= TAKEN_WITHIN {
            return Err(Ended::with(Exit::Failed, not_taken(answer.pid)));
        }
        std::thread::sleep(ASK_AGAIN);
    }
}

fn ask(bus: &BusName) -> anyhow::Result<StopAnswer> {
    stop::request(bus, "atas estop", ANSWER).map_err(|error| match error {
        BusError::NoAnswer { .. } => Ended::with(Exit::NoDaemon, silent(bus, &error)),
        error => error.into(),
    })
}

fn done(output: &mut Output) -> anyhow::Result<()> {
    if output.is_json() {
        return output.json(&json!({
            "op": ControlOp::ESTOP.name(),
            "outcome": "done",
            "stop": StopOutcome::STOPPED.name(),
        }));
    }
    output.line("stopped; `atas recover` re-arms")
}

/// The daemon has it, and does not tick.
fn not_taken(pid: u32) -> String {
    format!(
        "could not see the robot stop because atasd (process {pid}) has the stop, but no tick took it within {TAKEN_WITHIN:?}: its \
         ticks stand still, or, in lock-step, no frame comes. The stop counts with its next tick; until then it sends no command, and \
         the robot obeys none that has expired. See `atas status`; `kill -KILL {pid}` ends a daemon that hangs"
    )
}

/// The daemon does not answer: is it stopped, does it hang, or is it gone?
fn silent(bus: &BusName, error: &BusError) -> String {
    if let Some(stopped) = Stopped::owner(bus) {
        return format!(
            "could not see the robot stop because {stopped}; the stop waits for it and counts when it goes on"
        );
    }
    match Owner::of(bus) {
        Some(owner) => format!(
            "could not see the robot stop because {owner}, which owns the bus, does not answer within {ANSWER:?}: it hangs; the stop \
             waits for it, and `kill -KILL {}` ends it",
            owner.pid
        ),
        None => error.to_string(),
    }
}
