//! `atas estop --remote`: a stop over a connection of its own, with a bound.

use std::sync::mpsc::{RecvTimeoutError, sync_channel};
use std::time::{Duration, Instant};

use atas_console::arguments::RemoteArgument;
use atas_console::{Exit, ExitError, Output, estop};

use super::config::Target;
use super::{request, unexpected};
use crate::link::LinkError;
use crate::message::{Reply, Work, channel};

/// Longest time until the stop is confirmed or reported as not confirmed. Design choice: the
/// daemon answers within 2 s; the rest is for the link.
const BOUND: Duration = Duration::from_secs(4);
/// Pause before another attempt after a failure.
const RETRY: Duration = Duration::from_millis(100);
/// Remedy without confirmation.
const REMEDY: &str = "Use the emergency stop of the hardware, or run `atas estop` on the robot's \
                      machine";

/// Stops the robot of the server.
pub(super) fn stop(
    argument: &RemoteArgument,
    words: Vec<String>,
    output: &mut Output,
) -> anyhow::Result<()> {
    let label = argument.remote.clone().unwrap_or_default();
    let target = Target::find(argument).map_err(|error| {
        let exit = atas_console::exit_of(&error);
        ExitError::with_code(exit, format!("stop not sent: {error}. {REMEDY}"))
    })?;
    // The resolution of a name can block without limit, so this thread only waits.
    let until = Instant::now() + BOUND;
    let (sender, receiver) = sync_channel(1);
    std::thread::Builder::new()
        .name("stop".into())
        .spawn(move || {
            // The receiver may have given up.
            let _ = sender.send(attempts(&target, &words, until));
        })?;
    match receiver.recv_timeout(BOUND) {
        Ok(Ok(Reply::Stopped(name))) => match channel(&name) {
            Some(channel) => estop::print_stopped(output, channel),
            None => Err(unexpected(Reply::Stopped(name))),
        },
        // The daemon's own text, as on its machine.
        Ok(Ok(reply @ Reply::Failed { .. })) => Err(unexpected(reply)),
        Ok(Ok(reply)) => Err(not_confirmed(
            &format!("{}", unexpected(reply)),
            Exit::Refused,
        )),
        Ok(Err(error)) => {
            let exit = match error {
                LinkError::Tls(_) => Exit::Refused,
                _ => Exit::NoDaemon,
            };
            Err(not_confirmed(&no_answer(&label, &error), exit))
        }
        Err(RecvTimeoutError::Timeout | RecvTimeoutError::Disconnected) => {
            let error = LinkError::Silent(BOUND);
            Err(not_confirmed(&no_answer(&label, &error), Exit::NoDaemon))
        }
    }
}

fn no_answer(label: &str, error: &LinkError) -> String {
    match error {
        LinkError::Tls(_) => format!("{label}: {error}"),
        _ => format!("{label}: {error}; a stop that was sent may still take effect"),
    }
}

fn not_confirmed(why: &str, exit: Exit) -> anyhow::Error {
    ExitError::with_code(exit, format!("stop not confirmed: {why}. {REMEDY}"))
}

/// Sends the stop until there is an answer. A repeated stop has no further effect.
fn attempts(target: &Target, words: &[String], until: Instant) -> Result<Reply, LinkError> {
    loop {
        let work = Work::Run(words.to_vec());
        let error = match request(target, work, until) {
            Ok((_, reply)) => return Ok(reply),
            Err(error) => error,
        };
        let is_final = matches!(error, LinkError::Tls(_) | LinkError::Frame(_));
        if is_final || Instant::now() + RETRY >= until {
            return Err(error);
        }
        std::thread::sleep(RETRY);
    }
}
