//! A goal from its sending to its end: follow it, cancel it when asked to or when it takes too long.

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use shm_bus::writer_epoch;
use shm_schemas::GoalRequest;

use crate::{ClientError, GoalProgress, POLL, Session};

/// How long the daemon may take to confirm that a goal has ended (ours: fifty of its rounds).
const CONFIRMATION: Duration = Duration::from_secs(1);

/// How to follow a goal.
pub struct Pursuit<'a> {
    /// Where to.
    pub session: &'a Session,
    /// Set when the goal shall be cancelled.
    pub stop: &'a AtomicBool,
    /// How long it may take.
    pub timeout: Option<Duration>,
}

/// Why the client asked for an end.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Cancelled {
    /// It was told to stop.
    Interrupted,
    /// The goal took longer than this.
    TimedOut(Duration),
}

impl Pursuit<'_> {
    /// Sends the goal, once the daemon is armed, and follows it to its end. `each` is called after every look, with the progress so far.
    ///
    /// # Errors
    /// The daemon is not there, goes away or does not confirm; and what `each` says.
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
            if pending.ended() {
                return Ok((progress, cancelled.map(|(why, _)| why)));
            }
            match cancelled {
                None => {
                    cancelled = self.wants_end(begin).map(|why| (why, Instant::now()));
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

    fn wants_end(&self, begin: Instant) -> Option<Cancelled> {
        if self.stop.load(Ordering::Relaxed) {
            return Some(Cancelled::Interrupted);
        }
        let timeout = self.timeout.filter(|timeout| begin.elapsed() > *timeout)?;
        Some(Cancelled::TimedOut(timeout))
    }
}
