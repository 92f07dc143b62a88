//! Run of a daemon: robot and sensors, from the header that the daemon publishes at start.

use std::time::{Duration, Instant};

use shm_bus::{Bus, BusError, Subscriber};
use shm_schemas::capacity::{FINGERS, HANDS};
use shm_schemas::{RunHeader, Status, service};

use crate::POLL;

/// Longest wait for the header. Design choice: the daemon sends it to new readers every 4 ms.
const WAIT: Duration = Duration::from_millis(100);
/// Pause before the next request for a missing header. Design choice.
const RETRY_PAUSE: Duration = Duration::from_secs(1);

/// Run of the reporting daemon, as far as known.
#[derive(Debug, Default)]
pub struct Run {
    header: Box<RunHeader>,
    is_known: bool,
    /// Process id of the daemon.
    pid: u32,
    /// Open only while waiting for the header: the few reader slots are for recorders.
    port: Option<Subscriber<RunHeader>>,
    asked: Option<Instant>,
}

impl Run {
    /// Reads the run of the daemon with this status; unknown if the header does not arrive in time.
    pub fn read(bus: &Bus, status: &Status) -> Result<Self, BusError> {
        let mut run = Self::default();
        let begin = Instant::now();
        while !run.is_known && begin.elapsed() < WAIT {
            run.poll(bus, status)?;
            if !run.is_known {
                std::thread::sleep(POLL);
            }
        }
        run.port = None;
        Ok(run)
    }

    /// Checks for a new run. Returns true if the run changed or became known.
    pub fn poll(&mut self, bus: &Bus, status: &Status) -> Result<bool, BusError> {
        let is_another = self.pid != status.pid;
        if is_another {
            (self.pid, self.is_known, self.port, self.asked) = (status.pid, false, None, None);
        }
        if self.is_known || self.pid == 0 {
            return Ok(is_another);
        }
        if self.asked.is_none_or(|asked| asked.elapsed() > RETRY_PAUSE) {
            self.asked = Some(Instant::now());
            self.port = match bus.subscriber(service::RUN_HEADER) {
                // Next attempt a second later.
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

    /// Returns the header, if known.
    #[must_use]
    pub fn header(&self) -> Option<&RunHeader> {
        self.is_known.then_some(&*self.header)
    }

    /// Returns the number of fingertips with sensors per hand: 0 for a hand that is neither
    /// required nor publishing, the capacity of the payload if nothing is known.
    #[must_use]
    pub fn fingertips(&self, status: &Status) -> [usize; HANDS] {
        std::array::from_fn(|hand| {
            let (wiring, measured) = (&self.header.hands[hand], &status.hands[hand]);
            let is_there = wiring.required != 0 || measured.frames > 0;
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
    fn hand_without_sensors_has_no_fingertips() {
        let mut run = Run::default();
        let mut status = Status::default();
        assert_eq!(
            run.fingertips(&status),
            [FINGERS; HANDS],
            "all fingertips are shown"
        );
        run.is_known = true;
        (run.header.hands[0].fingers, run.header.hands[1].fingers) = (1, 3);
        run.header.hands[1].required = 1;
        assert_eq!(run.fingertips(&status), [0, 3]);
        status.hands[0].frames = 5;
        assert_eq!(run.fingertips(&status), [1, 3]);
    }
}
