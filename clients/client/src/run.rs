//! What runs: the robot and its sensors, as the daemon names them when it starts.

use std::time::{Duration, Instant};

use shm_bus::{Bus, BusError, Subscriber};
use shm_schemas::capacity::{FINGERS, HANDS};
use shm_schemas::{RunHeader, Status, service};

use crate::POLL;

/// How long one who asks once waits (ours: the daemon hands its header to new readers every 4 ms).
const WAIT: Duration = Duration::from_millis(100);
/// Pause before a header that did not come is asked for again (ours).
const AGAIN: Duration = Duration::from_secs(1);

/// The run of the daemon that reports, as far as it is known.
#[derive(Debug, Default)]
pub struct Run {
    header: Box<RunHeader>,
    is_known: bool,
    /// Process of the daemon.
    pid: u32,
    /// Open only while the header is awaited: its few places are the recorders'.
    port: Option<Subscriber<RunHeader>>,
    asked: Option<Instant>,
}

impl Run {
    /// The run of the daemon with this status; unknown if it does not say it at once.
    ///
    /// # Errors
    /// The shared memory of the daemon cannot be read.
    pub fn of(bus: &Bus, status: &Status) -> Result<Self, BusError> {
        let mut run = Self::default();
        let begin = Instant::now();
        while !run.is_known && begin.elapsed() < WAIT {
            run.look(bus, status)?;
            if !run.is_known {
                std::thread::sleep(POLL);
            }
        }
        run.port = None;
        Ok(run)
    }

    /// Looks what runs now. Whether that is another run than before, or is only now known.
    ///
    /// # Errors
    /// The shared memory of the daemon cannot be read.
    pub fn look(&mut self, bus: &Bus, status: &Status) -> Result<bool, BusError> {
        let is_another = self.pid != status.pid;
        if is_another {
            (self.pid, self.is_known, self.port, self.asked) = (status.pid, false, None, None);
        }
        if self.is_known || self.pid == 0 {
            return Ok(is_another);
        }
        if self.asked.is_none_or(|asked| asked.elapsed() > AGAIN) {
            self.asked = Some(Instant::now());
            self.port = match bus.subscriber(service::RUN_HEADER) {
                // Another second.
                Err(BusError::Full { .. }) => None,
                port => Some(port?),
            };
        }
        if let Some(port) = &mut self.port {
            self.is_known = port.newest(&mut self.header)?;
        }
        if self.is_known {
            self.port = None;
        }
        Ok(is_another || self.is_known)
    }

    /// How it began, if the daemon has said so.
    #[must_use]
    pub fn header(&self) -> Option<&RunHeader> {
        self.is_known.then_some(&*self.header)
    }

    /// Fingers of each hand that feel: none of a hand that nobody requires and that has said nothing; all that payloads have room
    /// for where nothing is known.
    #[must_use]
    pub fn fingers(&self, status: &Status) -> [usize; HANDS] {
        std::array::from_fn(|hand| {
            let (wiring, felt) = (&self.header.hands[hand], &status.hands[hand]);
            let is_there = wiring.required != 0 || felt.frames > 0;
            match (self.is_known, is_there) {
                (false, _) => FINGERS,
                (true, true) => (wiring.fingers as usize).min(FINGERS),
                (true, false) => 0,
            }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_hand_has_the_fingers_that_the_daemon_says_and_none_where_nobody_feels() {
        let mut run = Run::default();
        let mut status = Status::default();
        assert_eq!(run.fingers(&status), [FINGERS; HANDS], "nothing is hidden");
        run.is_known = true;
        (run.header.hands[0].fingers, run.header.hands[1].fingers) = (1, 3);
        run.header.hands[1].required = 1;
        assert_eq!(run.fingers(&status), [0, 3]);
        status.hands[0].frames = 5;
        assert_eq!(run.fingers(&status), [1, 3]);
    }
}
