//! Execution of a goal by a client: sending, progress, cancellation on request or timeout.

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use shm_bus::writer_epoch;
use shm_schemas::GoalRequest;

use crate::{ClientError, GoalProgress, POLL, Session};

/// Longest wait for the daemon's confirmation that a goal has ended. Design choice: fifty of its
/// cycles.
const CONFIRMATION: Duration = Duration::from_secs(1);

/// Options of a goal's execution.
pub struct GoalExecution<'a> {
    /// Session that sends the goal.
    pub session: &'a Session,
    /// Flag that cancels the goal.
    pub stop: &'a AtomicBool,
    /// Longest duration of the goal.
    pub timeout: Option<Duration>,
}

/// Cause of a cancellation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Cancelled {
    /// The stop flag was set.
    Interrupted,
    /// The goal took longer than this.
    TimedOut(Duration),
}

impl GoalExecution<'_> {
    /// Sends the goal when the daemon is armed, and waits for its end. Calls `each` after every
    /// poll with the progress so far.
    ///
    /// # Errors
    /// No daemon, a lost daemon, no confirmation, or an error of `each`.
    pub fn run<E: From<ClientError>>(
        &self,
        goal: &GoalRequest,
        mut each: impl FnMut(&GoalProgress) -> Result<(), E>,
    ) -> Result<(GoalProgress, Option<Cancelled>), E> {
        let begin = Instant::now();
        self.session.wait_until_armed(self.stop)?;
        let request = GoalRequest {
            stamp: self.session.stamp(),
            goal_id: writer_epoch(),
            ..*goal
        };
        let client = self
            .session
            .bus()
            .goal_client()
            .map_err(ClientError::from)?;
        let mut pending = client.send(&request).map_err(ClientError::from)?;
        let mut progress = GoalProgress::default();
        let mut cancelled = None;
        loop {
            while let Some(update) = pending.next().map_err(ClientError::from)? {
                progress.add(&update);
            }
            each(&progress)?;
            if pending.has_ended() {
                return Ok((progress, cancelled.map(|(why, _)| why)));
            }
            match cancelled {
                None => {
                    cancelled = self.cancellation(begin).map(|why| (why, Instant::now()));
                    if cancelled.is_some() {
                        pending.cancel();
                    }
                }
                Some((_, asked)) if asked.elapsed() > CONFIRMATION => {
                    return Err(ClientError::Unconfirmed(CONFIRMATION).into());
                }
                Some(_) => {}
            }
            std::thread::sleep(POLL);
        }
    }

    fn cancellation(&self, begin: Instant) -> Option<Cancelled> {
        if self.stop.load(Ordering::Relaxed) {
            return Some(Cancelled::Interrupted);
        }
        let timeout = self.timeout.filter(|timeout| begin.elapsed() > *timeout)?;
        Some(Cancelled::TimedOut(timeout))
    }
}
