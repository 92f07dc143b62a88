//! Selection and spacing of replayed frames.

use shm_schemas::Stamp;

/// Time to the next frame between the rounds of a single frame, ns. Design choice: 100 Hz.
const DEFAULT_PERIOD_NS: u64 = 10_000_000;

/// Speed of a replay.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Pace {
    /// Recorded spacing, divided by this factor.
    Speed(f64),
    /// Fixed rate, Hz.
    Rate(f64),
}

/// Position of a frame in the replay.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Step {
    /// Increment of the sequence: more than 1 after lost frames.
    pub advance: u64,
    /// Time since the previous frame, ns.
    pub after_ns: u64,
}

/// Converts recorded stamps to positions.
#[derive(Clone, Debug)]
pub struct Timeline {
    pace: Pace,
    last: Option<Stamp>,
    has_begun: bool,
    usual_ns: u64,
}

impl Timeline {
    /// Creates a timeline before its first frame.
    #[must_use]
    pub fn new(pace: Pace) -> Self {
        Self {
            pace,
            last: None,
            has_begun: false,
            usual_ns: DEFAULT_PERIOD_NS,
        }
    }

    /// Restarts the recording.
    pub fn begin_round(&mut self) {
        self.last = None;
    }

    /// Returns the position of the frame with this stamp; `None` if it is not newer than all
    /// before.
    pub fn step(&mut self, stamp: Stamp) -> Option<Step> {
        let (advance, recorded_ns) = match self.last {
            None if self.has_begun => (1, self.usual_ns),
            None => (1, 0),
            // Another process of the sensor, on the same clock unless the machine was restarted.
            Some(last) if last.writer_epoch != stamp.writer_epoch => (
                1,
                match stamp.captured_ns.saturating_sub(last.captured_ns) {
                    0 => self.usual_ns,
                    after_ns => after_ns,
                },
            ),
            Some(last)
                if stamp.sequence <= last.sequence || stamp.captured_ns <= last.captured_ns =>
            {
                return None;
            }
            Some(last) => {
                let advance = stamp.sequence - last.sequence;
                let after_ns = stamp.captured_ns - last.captured_ns;
                self.usual_ns = after_ns / advance;
                (advance, after_ns)
            }
        };
        self.last = Some(stamp);
        let after_ns = match self.pace {
            _ if !self.has_begun => 0,
            Pace::Speed(speed) => (recorded_ns as f64 / speed) as u64,
            Pace::Rate(rate_hz) => (1e9 / rate_hz) as u64,
        };
        self.has_begun = true;
        Some(Step {
            advance,
            // Two frames cannot have the same time.
            after_ns: after_ns.max(1),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::{Pace, Step, Timeline};
    use shm_schemas::Stamp;

    /// Recorded epochs, sequences and times, ms; a round begins at epoch 0.
    const RECORDED: [(u64, u64, u64); 11] = [
        (7, 40, 1000),
        (7, 41, 1010),
        (7, 41, 1010),
        (7, 44, 1040),
        (7, 43, 1030),
        (7, 45, 1040),
        (7, 46, 1050),
        (9, 0, 1300),
        (9, 1, 1304),
        (0, 0, 0),
        (7, 40, 1000),
    ];

    fn played(pace: Pace) -> Vec<Option<(u64, u64)>> {
        let mut timeline = Timeline::new(pace);
        let mut steps = Vec::new();
        for (writer_epoch, sequence, ms) in RECORDED {
            if writer_epoch == 0 {
                timeline.begin_round();
                continue;
            }
            let step = timeline.step(Stamp {
                sequence,
                captured_ns: ms * 1_000_000,
                writer_epoch,
            });
            steps.push(step.map(|Step { advance, after_ns }| (advance, after_ns)));
        }
        steps
    }

    #[test]
    fn gaps_are_kept_old_frames_skipped_rounds_repeated() {
        let with = |after_ns: [u64; 7]| {
            let [a, b, c, d, e, f, g] = after_ns;
            let skipped = None;
            vec![
                Some((1, a)),
                Some((1, b)),
                skipped,
                Some((3, c)),
                skipped,
                skipped,
                Some((2, d)),
                Some((1, e)),
                Some((1, f)),
                Some((1, g)),
            ]
        };
        let ms = |ms: [u64; 6]| {
            with(
                [1].into_iter()
                    .chain(ms.map(|ms| ms * 500_000))
                    .collect::<Vec<_>>()
                    .try_into()
                    .unwrap(),
            )
        };
        assert_eq!(played(Pace::Speed(2.0)), ms([10, 30, 10, 250, 4, 4]));
        assert_eq!(played(Pace::Rate(500.0)), ms([4; 6]));
    }
}
