//! `atas estop`: stops the robot over a separate channel that other clients cannot block. `atas`
//! and the server for other machines use it.
//!
//! It joins no bus, takes no lock and cleans up nothing first ([`shm_bus::stop`]). Without an
//! answer it also sends a control request.

use std::time::{Duration, Instant};

use atas_client::{StopChannel, StopReply, Stopped, request_stop};
use serde_json::json;
use shm_bus::{BusError, BusName, Owner};
use shm_schemas::{ControlOp, StopOutcome};

use crate::{Exit, ExitError, Output};

/// Longest wait for the daemon's answer. Design choice: an answer takes one tick, or 20 ms without
/// ticks.
const ANSWER_TIMEOUT: Duration = Duration::from_millis(800);
/// Longest wait for a tick that executes the stop. Design choice: 1000 ticks.
const EXECUTION_TIMEOUT: Duration = Duration::from_secs(1);
/// Pause between two requests. Each request is a stop and an event of the daemon.
const RETRY_PAUSE: Duration = Duration::from_millis(100);

/// Stops the robot and returns the channel of the answer. Succeeds only after a tick has executed
/// the stop.
///
/// # Errors
/// The stop is not confirmed; the error has an exit code and names the cause.
pub fn stop(bus: &BusName) -> anyhow::Result<StopChannel> {
    let begin = Instant::now();
    loop {
        let answer = send_stop(bus)?;
        if answer.outcome == StopOutcome::STOPPED {
            return Ok(answer.channel);
        }
        if begin.elapsed() >= EXECUTION_TIMEOUT {
            return Err(ExitError::with_code(
                Exit::Failed,
                not_executed_text(answer.pid.unwrap_or_default()),
            ));
        }
        std::thread::sleep(RETRY_PAUSE);
    }
}

fn send_stop(bus: &BusName) -> anyhow::Result<StopReply> {
    request_stop(bus, "atas estop", ANSWER_TIMEOUT).map_err(|error| match error {
        BusError::NoAnswer { .. } => {
            ExitError::with_code(Exit::NoDaemon, no_answer_text(bus, &error))
        }
        error => error.into(),
    })
}

/// Prints that the robot is stopped.
///
/// # Errors
/// Standard output cannot be written.
pub fn print_stopped(output: &mut Output, channel: StopChannel) -> anyhow::Result<()> {
    if output.is_json() {
        return output.json(&json!({
            "op": ControlOp::ESTOP.name(),
            "outcome": "done",
            "stop": StopOutcome::STOPPED.name(),
            "channel": channel.name(),
        }));
    }
    output.line(match channel {
        StopChannel::Socket => "stopped; `atas recover` re-arms",
        StopChannel::Control => {
            "stopped by a control request, because the stop socket did not answer; `atas recover` re-arms"
        }
    })
}

/// Error text if the daemon received the stop but does not tick.
fn not_executed_text(pid: u32) -> String {
    format!(
        "stop not confirmed: atasd (process {pid}) received it, but no tick took it within \
         {EXECUTION_TIMEOUT:?}. Its ticks stand still, or no frames arrive in lock-step. The stop takes \
         effect with the next tick; until then the daemon sends no command, and the robot ignores \
         expired commands. See `atas status`; `kill -KILL {pid}` ends a hung daemon"
    )
}

/// Error text if the daemon does not answer: it is stopped, hung or gone.
fn no_answer_text(bus: &BusName, error: &BusError) -> String {
    if let Some(stopped) = Stopped::owner(bus) {
        return format!("stop not confirmed: {stopped}; the stop takes effect when it continues");
    }
    match Owner::find(bus) {
        Some(owner) => format!(
            "stop not confirmed: {owner}, which owns the bus, does not answer within {ANSWER_TIMEOUT:?}. \
             The stop takes effect when it answers again; `kill -KILL {}` ends it",
            owner.pid
        ),
        None => error.to_string(),
    }
}
