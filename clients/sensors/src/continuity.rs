//! What a device's own frame counter says about frames that were lost, doubled or late.
//!
//! In: the count of every valid frame, in order of arrival. Out: an [`Arrival`] per frame, and running totals.
//! A judgement here is information only: no frame is ever refused because of its count.
//!
//! With `step` the signed distance from the newest count, modulo 2^bits (here for 16 bits):
//!
//! | step | meaning | effect |
//! |---|---|---|
//! | 1 | the next frame | – |
//! | 2 … 32767 | a gap | `lost` grows by step − 1 |
//! | 0 … −1023, not missing | the same frame again | `duplicates` grows by 1 |
//! | −1 … −1023, missing | a frame that was overtaken | `late` grows by 1, `lost` shrinks by 1 |
//! | −1024 … −32768 | the device began to count anew | `restarts` grows by 1, nothing is lost |
//!
//! A jump by more than 1024, in either direction, is taken back and counted as a **stray** when the frame after it
//! continues from before the jump: then one count was wrong (a damaged frame whose checksum fits by chance), and
//! thousands of frames were not lost. So `lost` is the number of counts between the first and the newest that never came.

/// How far back a count is a duplicate or late frame rather than a restart, counts: one second at 1 kHz. A power of
/// two. Ours; larger hides restarts, smaller takes a repeated chunk of the stream for a restart.
pub const WINDOW: u32 = 1024;

/// How one frame relates to those before it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Arrival {
    /// The first frame of all.
    First,
    /// A newer frame after `gap` missing ones.
    Newer {
        /// Frames missing directly before this one.
        gap: u32,
    },
    /// A frame that was here before.
    Duplicate,
    /// A frame that a newer one overtook.
    Late,
    /// The first frame of a device that began to count anew.
    Restart,
}

impl Arrival {
    /// By how much the frame advances a gap-free numbering; `None` for frames that are not newer than all before.
    #[must_use]
    pub fn advance(self) -> Option<u64> {
        match self {
            Self::First | Self::Restart => Some(1),
            Self::Newer { gap } => Some(u64::from(gap) + 1),
            Self::Duplicate | Self::Late => None,
        }
    }

    /// Its name in tables.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::First => "first",
            Self::Newer { gap: 0 } => "next",
            Self::Newer { .. } => "gap",
            Self::Duplicate => "duplicate",
            Self::Late => "late",
            Self::Restart => "restart",
        }
    }
}

/// Totals since the first frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Totals {
    /// Counts that never came.
    pub lost: u64,
    /// Frames that came again.
    pub duplicates: u64,
    /// Frames that came after a newer one.
    pub late: u64,
    /// Times the device began to count anew.
    pub restarts: u64,
    /// Frames whose count was wrong.
    pub strays: u64,
}

/// Follows one device's counter.
#[derive(Clone, Debug)]
pub struct Continuity {
    /// Bits of a count that are not there: all arithmetic is done on counts shifted up by so many.
    unused_bits: u32,
    track: Option<Track>,
    /// The device was told to begin anew: a count that goes back is a restart, however near it is.
    restart_expected: bool,
    /// The track before a jump, until the frame after it confirms or refutes the jump.
    before_jump: Option<Track>,
}

impl Continuity {
    /// For a counter of so many bits, 11 to 32.
    #[must_use]
    pub fn new(bits: u32) -> Self {
        Self {
            unused_bits: 32 - bits.clamp(11, 32),
            track: None,
            restart_expected: false,
            before_jump: None,
        }
    }

    /// The device was told to begin anew, so its counts may too.
    pub fn expect_restart(&mut self) {
        self.restart_expected = true;
    }

    /// Judges the next valid frame by its count.
    pub fn observe(&mut self, count: u32) -> Arrival {
        let Some(track) = self.track.as_mut() else {
            self.track = Some(Track::new(count, self.unused_bits));
            return Arrival::First;
        };
        if std::mem::take(&mut self.restart_expected) && track.step_to(count) <= 0 {
            self.before_jump = None;
            return track.restart(count);
        }
        if let Some(before) = self.before_jump.take()
            && before.continues_with(count)
            && !track.continues_with(count)
        {
            *track = before;
            track.totals.strays += 1;
        }
        let before = *track;
        let arrival = track.observe(count);
        if !before.continues_with(count) && arrival.advance().is_some() {
            self.before_jump = Some(before);
        }
        arrival
    }

    /// Totals since the first frame.
    #[must_use]
    pub fn totals(&self) -> Totals {
        self.track.map(|track| track.totals).unwrap_or_default()
    }
}

#[derive(Clone, Copy, Debug)]
struct Track {
    newest: u32,
    unused_bits: u32,
    /// Bit `count % WINDOW` set: that count, within the window up to `newest`, is booked as lost.
    missing: [u64; WINDOW as usize / 64],
    totals: Totals,
}

impl Track {
    fn new(count: u32, unused_bits: u32) -> Self {
        Self {
            newest: count,
            unused_bits,
            missing: [0; WINDOW as usize / 64],
            totals: Totals::default(),
        }
    }

    /// Signed distance from the newest count.
    fn step_to(&self, count: u32) -> i32 {
        (count.wrapping_sub(self.newest) << self.unused_bits).cast_signed() >> self.unused_bits
    }

    /// Whether the count is a plausible successor.
    fn continues_with(&self, count: u32) -> bool {
        (1..=WINDOW.cast_signed()).contains(&self.step_to(count))
    }

    fn observe(&mut self, count: u32) -> Arrival {
        let step = self.step_to(count);
        if step > 0 {
            self.advance_to(count, step.unsigned_abs() - 1)
        } else if step.unsigned_abs() >= WINDOW {
            self.restart(count)
        } else {
            self.look_back_at(count)
        }
    }

    fn restart(&mut self, count: u32) -> Arrival {
        let totals = Totals {
            restarts: self.totals.restarts + 1,
            ..self.totals
        };
        *self = Self {
            totals,
            ..Self::new(count, self.unused_bits)
        };
        Arrival::Restart
    }

    fn advance_to(&mut self, count: u32, gap: u32) -> Arrival {
        for back in 1..=gap.min(WINDOW - 1) {
            self.mark(count.wrapping_sub(back), true);
        }
        self.mark(count, false);
        self.newest = count;
        self.totals.lost += u64::from(gap);
        Arrival::Newer { gap }
    }

    fn look_back_at(&mut self, count: u32) -> Arrival {
        if self.mark(count, false) {
            self.totals.late += 1;
            self.totals.lost -= 1;
            Arrival::Late
        } else {
            self.totals.duplicates += 1;
            Arrival::Duplicate
        }
    }

    /// Books a count as missing or not; returns how it was booked before.
    fn mark(&mut self, count: u32, missing: bool) -> bool {
        let slot = (count % WINDOW) as usize;
        let (word, bit) = (&mut self.missing[slot / 64], 1 << (slot % 64));
        let was_missing = *word & bit != 0;
        *word = if missing { *word | bit } else { *word & !bit };
        was_missing
    }
}

#[cfg(test)]
mod tests {
    use super::{Arrival, Continuity, Totals};
    use proptest::prelude::*;

    fn totals_of(counts: impl IntoIterator<Item = u16>) -> Totals {
        let mut continuity = Continuity::new(16);
        for count in counts {
            continuity.observe(u32::from(count));
        }
        continuity.totals()
    }

    #[test]
    fn every_row_of_the_table() {
        let none = Totals::default();
        let check = |counts: &[u16], expected: Totals| {
            assert_eq!(totals_of(counts.to_vec()), expected, "{counts:?}")
        };
        check(&[], none);
        check(&[7], none);
        check(&[7, 8, 9], none);
        check(&[65534, 65535, 0, 1], none);
        check(&[65534, 1], Totals { lost: 2, ..none });
        check(&[5, 9], Totals { lost: 3, ..none });
        check(
            &[5, 5, 5, 6],
            Totals {
                duplicates: 2,
                ..none
            },
        );
        check(
            &[5, 6, 7, 5, 6, 7, 8],
            Totals {
                duplicates: 3,
                ..none
            },
        );
        check(
            &[0, 65535, 1],
            Totals {
                duplicates: 1,
                ..none
            },
        );
        check(&[5, 7, 6, 8], Totals { late: 1, ..none });
        check(
            &[5, 7, 6, 6, 8],
            Totals {
                late: 1,
                duplicates: 1,
                ..none
            },
        );
        check(&[65534, 0, 65535, 1], Totals { late: 1, ..none });
        check(
            &[5, 9, 7, 10],
            Totals {
                lost: 2,
                late: 1,
                ..none
            },
        );
        check(
            &[0, 32767, 32768],
            Totals {
                lost: 32766,
                ..none
            },
        );
        check(
            &[20000, 0, 1],
            Totals {
                restarts: 1,
                ..none
            },
        );
        check(&[5, 6, 20000, 7, 8], Totals { strays: 1, ..none });
        check(&[5, 6, 50000, 7, 8], Totals { strays: 1, ..none });
        check(
            &[5, 6, 20000, 9, 10],
            Totals {
                strays: 1,
                lost: 2,
                ..none
            },
        );
        check(&[5, 6, 5000, 5001], Totals { lost: 4993, ..none });
        check(&[0, 1024, 1025], Totals { lost: 1023, ..none });
        check(
            &[5000, 3976, 3977],
            Totals {
                restarts: 1,
                ..none
            },
        );
        check(
            &[5000, 3977, 5001],
            Totals {
                duplicates: 1,
                ..none
            },
        );
    }

    #[test]
    fn arrivals_number_the_frames_without_going_back() {
        let mut continuity = Continuity::new(16);
        let advances: Vec<_> = [5, 6, 9, 9, 8, 10]
            .map(|count| continuity.observe(count).advance())
            .to_vec();
        assert_eq!(advances, [Some(1), Some(1), Some(3), None, None, Some(1)]);
        assert_eq!(Continuity::new(16).observe(3), Arrival::First);
    }

    #[test]
    fn a_restart_that_was_asked_for_is_no_run_of_duplicates() {
        let mut continuity = Continuity::new(32);
        let arrivals = [5, 6].map(|count| continuity.observe(count));
        assert_eq!(arrivals[1], Arrival::Newer { gap: 0 });
        continuity.expect_restart();
        assert_eq!(
            [1, 2].map(|count| continuity.observe(count))[0],
            Arrival::Restart
        );
        assert_eq!(
            (continuity.totals().restarts, continuity.totals().duplicates),
            (1, 0)
        );
    }

    #[test]
    fn wider_counters_wrap_at_their_own_width() {
        let mut continuity = Continuity::new(32);
        for count in [u32::MAX - 1, u32::MAX, 0, 70_000, 69_999, 70_001] {
            continuity.observe(count);
        }
        let expected = Totals {
            lost: 69_998,
            late: 1,
            ..Totals::default()
        };
        assert_eq!(continuity.totals(), expected);
    }

    proptest! {
        /// Frames of a counter of which some are dropped and some repeated at once: the totals are exact.
        #[test]
        fn drops_and_repeats_are_counted_exactly(start: u16, fates in prop::collection::vec(0_u8..4, 1..3000)) {
            let copies = |fate: u8| match fate { 0 => 0, 1 => 2, _ => 1 };
            let last = fates.iter().rposition(|&f| f != 0).unwrap_or(0);
            let first = fates.iter().position(|&f| f != 0).unwrap_or(0);
            let kept = &fates[first..=last.max(first)];
            let counts = fates.iter().enumerate()
                .flat_map(|(i, &fate)| std::iter::repeat_n(start.wrapping_add(i as u16), copies(fate)));
            let lost = kept.iter().filter(|&&f| f == 0).count() as u64;
            let duplicates = kept.iter().filter(|&&f| f == 1).count() as u64;
            let expected = if fates.iter().all(|&f| f == 0) { Totals::default() } else {
                Totals { lost, duplicates, ..Totals::default() }
            };
            prop_assert_eq!(totals_of(counts), expected);
        }

        /// No input upsets the books.
        #[test]
        fn any_counts_are_survived(counts in prop::collection::vec(any::<u16>(), 0..2000)) {
            totals_of(counts);
        }
    }
}
