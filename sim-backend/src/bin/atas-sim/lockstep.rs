//! Lock-step with the daemon: the world advances once the daemon has answered the joint state of
//! the tick. Time is virtual, so runs are bit-identical and as fast as both processes allow.
//!
//! Without daemon response the world waits, without a time limit.

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use shm_schemas::JointCommand;

use crate::failure::Failure;
use crate::session::Session;
use crate::wait::Wait;

pub(crate) fn run(
    session: &mut Session,
    duration: Option<Duration>,
    stop: &AtomicBool,
) -> Result<(), Failure> {
    // Discards commands of an earlier world.
    session.newest_command()?;
    while !stop.load(Ordering::Relaxed) && !session.is_over(duration) {
        session.publish_truth()?;
        let command = match session.publish()? {
            Some(sequence) => match await_answer(session, sequence, stop)? {
                Some(command) => Some(command),
                None => return Ok(()),
            },
            // A fault dropped the joint state, so no response can come.
            None => None,
        };
        session.advance(command.as_ref())?;
    }
    session.publish_truth()
}

/// Waits for the command that answers a joint state; returns `None` if `stop` is set.
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
        wait.pause(|| session.connect_readers())?;
    }
    Ok(None)
}
