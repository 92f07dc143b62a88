//! Rate of a topic.

use std::time::{Duration, Instant};

/// Rate limiter that keeps the mean rate.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pace {
    interval: Duration,
    due: Instant,
}

impl Pace {
    pub(super) fn new(hz: f64) -> Self {
        Self {
            interval: Duration::from_secs_f64(1.0 / hz),
            due: Instant::now(),
        }
    }

    /// Returns true if a message is due, and schedules the next one.
    pub(super) fn is_due(&mut self) -> bool {
        self.is_due_at(Instant::now())
    }

    fn is_due_at(&mut self, now: Instant) -> bool {
        if now < self.due {
            return false;
        }
        // After a pause, one message, not all that were missed.
        self.due = (self.due + self.interval).max(now.checked_sub(self.interval).unwrap_or(now));
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn mean_rate_is_kept_between_polls() {
        let mut pace = Pace::new(30.0);
        let begin = Instant::now();
        let polls = (0..1000).map(|n| begin + Duration::from_millis(10 * n));
        let due = polls.filter(|at| pace.is_due_at(*at)).count();
        assert!((299..=302).contains(&due), "{due} in 10 s at 30 Hz");
    }
}
