//! In step with the daemon: the world goes on when the daemon has answered the joint state of this tick. Virtual time, so
//! a run repeats bit for bit and goes as fast as both processes go.
//!
//! The daemon ticks only while it has something to do; until then the world stands still, however long that takes.

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use shm_schemas::JointCommand;

use crate::failure::Failure;
use crate::session::Session;
use crate::wait::Wait;

/// Runs until the duration of simulated time is over or `stop` is set.
pub(crate) fn run(
    session: &mut Session,
    duration: Option<Duration>,
    stop: &AtomicBool,
) -> Result<(), Failure> {
    // A command from before this world answers nothing of it.
    session.newest_command()?;
    while !stop.load(Ordering::Relaxed) && !session.has_lasted(duration) {
        session.publish_truth()?;
        let command = match session.publish()? {
            Some(sequence) => match await_answer(session, sequence, stop)? {
                Some(command) => Some(command),
                None => return Ok(()),
            },
            // A fault kept the joint state from the daemon: there is nothing that it could answer.
            None => None,
        };
        session.advance(command.as_ref())?;
    }
    session.publish_truth()
}

/// The command that answers a joint state; `None` if the process shall end.
pub(crate) fn await_answer(
    session: &mut Session,
    sequence: u64,
    stop: &AtomicBool,
) -> Result<Option<JointCommand>, Failure> {
    let wait = Wait::begin();
    while !stop.load(Ordering::Relaxed) {
        if let Some(command) = session
            .newest_command()?
            .filter(|command| command.answers_sequence == sequence)
        {
            return Ok(Some(command));
        }
        wait.pause(|| session.greet())?;
    }
    Ok(None)
}
