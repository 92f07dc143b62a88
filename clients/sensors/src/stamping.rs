//! Capture times of frames from devices that send no time, estimated from the time of reading.
//!
//! One read often returns several frames, because the operating system or the latency timer of a
//! USB bridge delivers in bursts. The newest frame gets the time of the read. The others are spaced
//! before it by the nominal period, or closer if they would overlap the previous read. The
//! transport delay is unknown and not subtracted.
//!
//! Invariants: stamps strictly increase. No stamp is later than its read, if the clock advances by
//! at least one nanosecond per frame between reads.

/// Assigns stamps to the frames of one device.
#[derive(Clone, Debug)]
pub struct Stamper {
    period_ns: u64,
    last_ns: u64,
}

impl Stamper {
    /// Creates a stamper for a device with this nominal frame period, ns.
    #[must_use]
    pub fn new(period_ns: u64) -> Self {
        Self {
            period_ns,
            last_ns: 0,
        }
    }

    /// Returns capture times, ns, of `frames` frames that the read at `read_ns` returned, oldest
    /// first.
    pub fn spread(&mut self, read_ns: u64, frames: usize) -> impl Iterator<Item = u64> + use<> {
        let frames = frames as u64;
        let room_ns = read_ns.saturating_sub(self.last_ns);
        let spacing_ns = room_ns
            .checked_div(frames)
            .unwrap_or(0)
            .clamp(1, self.period_ns.max(1));
        // Both are equal unless the clock stood still.
        let newest_ns = read_ns.max(self.last_ns + frames * spacing_ns);
        if frames > 0 {
            self.last_ns = newest_ns;
        }
        (0..frames)
            .rev()
            .map(move |older| newest_ns.saturating_sub(older * spacing_ns))
    }
}

#[cfg(test)]
mod tests {
    use super::Stamper;
    use proptest::prelude::*;

    #[test]
    fn frames_of_one_read_are_spaced_by_the_period() {
        let mut stamper = Stamper::new(1000);
        let mut check = |read_ns, frames, expected: &[u64]| {
            assert_eq!(
                stamper.spread(read_ns, frames).collect::<Vec<_>>(),
                expected
            );
        };
        check(10_000, 1, &[10_000]);
        check(11_000, 1, &[11_000]);
        check(11_500, 0, &[]);
        check(14_000, 3, &[12_000, 13_000, 14_000]);
        check(14_600, 3, &[14_200, 14_400, 14_600]);
        check(30_000, 2, &[29_000, 30_000]);
        check(30_000, 2, &[30_001, 30_002]);
    }

    proptest! {
        #[test]
        fn stamps_increase_and_are_never_in_the_future(
            reads in prop::collection::vec((300_u64..5_000_000, 0_usize..257), 1..200),
            period_ns in 1_u64..200_000_000,
        ) {
            let mut stamper = Stamper::new(period_ns);
            let (mut now_ns, mut last_ns) = (1_000_000_000, 0);
            for (pause_ns, frames) in reads {
                now_ns += pause_ns;
                for stamp_ns in stamper.spread(now_ns, frames) {
                    prop_assert!(stamp_ns > last_ns && stamp_ns <= now_ns);
                    last_ns = stamp_ns;
                }
            }
        }
    }
}
