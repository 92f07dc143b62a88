//! Detection of lost, duplicate and late frames from the device's frame counter.
//!
//! Input: the count of every valid frame, in order of arrival. Output: an [`Arrival`] per frame,
//! and running totals. The result is informative only: no frame is dropped because of its count.
//!
//! `step` is the signed distance from the newest count, modulo 2^bits (here for 16 bits):
//!
//! | step | meaning | effect |
//! |---|---|---|
//! | 1 | the next frame | – |
//! | 2 … 32767 | a gap | `lost` grows by step − 1 |
//! | 0 … −1023, not missing | the frame again | `duplicates` grows by 1 |
//! | −1 … −1023, missing | an overtaken frame | `late` grows by 1, `lost` shrinks by 1 |
//! | −1024 … −32768 | the device restarted its counter | `restarts` grows by 1 |
//!
//! A jump by more than 1024 is revoked if the next frame continues from before it. It then counts
//! as a **stray**: one wrong count whose checksum matched by chance. Thus `lost` is the number of
//! missing counts between the first and the newest.

/// Largest backward step of a duplicate or late frame, counts; a power of two. Design choice: one
/// second at 1 kHz. Too large hides restarts; too small takes a repeated chunk for a restart.
pub const WINDOW: u32 = 1024;

/// Relation of a frame to the preceding ones.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Arrival {
    /// First frame since the start.
    First,
    /// Newer frame after `gap` missing ones.
    Newer {
        /// Frames missing directly before this one.
        gap: u32,
    },
    /// Repeated frame.
    Duplicate,
    /// Frame overtaken by a newer one.
    Late,
    /// First frame after the device restarted its counter.
    Restart,
}

impl Arrival {
    /// Returns the sequence increment including gaps; `None` if the frame is not the newest.
    #[must_use]
    pub fn advance(self) -> Option<u64> {
        match self {
            Self::First | Self::Restart => Some(1),
            Self::Newer { gap } => Some(u64::from(gap) + 1),
            Self::Duplicate | Self::Late => None,
        }
    }

    /// Returns the name used in tables.
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
    /// Missing frames.
    pub lost: u64,
    /// Repeated frames.
    pub duplicates: u64,
    /// Overtaken frames.
    pub late: u64,
    /// Counter restarts.
    pub restarts: u64,
    /// Frames with a wrong count.
    pub strays: u64,
}

/// Tracks the frame counter of one device.
#[derive(Clone, Debug)]
pub struct Continuity {
    /// 32 minus the counter's width; counts are shifted up by this.
    unused_bits: u32,
    state: Option<CounterState>,
    /// A restart was requested: the next non-increasing count is one, even within [`WINDOW`].
    restart_expected: bool,
    /// State before a jump, until the next frame confirms or refutes it.
    before_jump: Option<CounterState>,
}

impl Continuity {
    /// Creates a tracker for 11 to 32 counter bits.
    #[must_use]
    pub fn new(bits: u32) -> Self {
        Self {
            unused_bits: 32 - bits.clamp(11, 32),
            state: None,
            restart_expected: false,
            before_jump: None,
        }
    }

    /// Expects a counter restart after a start command.
    pub fn expect_restart(&mut self) {
        self.restart_expected = true;
    }

    /// Classifies the next valid frame by its count.
    pub fn observe(&mut self, count: u32) -> Arrival {
        let Some(track) = self.state.as_mut() else {
            self.state = Some(CounterState::new(count, self.unused_bits));
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

    /// Returns the totals.
    #[must_use]
    pub fn totals(&self) -> Totals {
        self.state.map(|track| track.totals).unwrap_or_default()
    }
}

#[derive(Clone, Copy, Debug)]
struct CounterState {
    newest: u32,
    unused_bits: u32,
    /// Bit `count % WINDOW`: that count is missing, within the window up to `newest`.
    missing: [u64; WINDOW as usize / 64],
    totals: Totals,
}

impl CounterState {
    fn new(count: u32, unused_bits: u32) -> Self {
        Self {
            newest: count,
            unused_bits,
            missing: [0; WINDOW as usize / 64],
            totals: Totals::default(),
        }
    }

    /// Returns the signed distance from the newest count.
    fn step_to(&self, count: u32) -> i32 {
        (count.wrapping_sub(self.newest) << self.unused_bits).cast_signed() >> self.unused_bits
    }

    /// Returns whether the count can directly follow.
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
            self.classify_past(count)
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

    fn classify_past(&mut self, count: u32) -> Arrival {
        if self.mark(count, false) {
            self.totals.late += 1;
            self.totals.lost -= 1;
            Arrival::Late
        } else {
            self.totals.duplicates += 1;
            Arrival::Duplicate
        }
    }

    /// Sets whether a count is missing; returns the previous value.
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
    fn totals_match_every_table_row() {
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
    fn late_frames_do_not_advance_the_sequence() {
        let mut continuity = Continuity::new(16);
        let advances: Vec<_> = [5, 6, 9, 9, 8, 10]
            .map(|count| continuity.observe(count).advance())
            .to_vec();
        assert_eq!(advances, [Some(1), Some(1), Some(3), None, None, Some(1)]);
        assert_eq!(Continuity::new(16).observe(3), Arrival::First);
    }

    #[test]
    fn expected_restart_is_not_counted_as_duplicates() {
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
    fn wide_counter_wraps_at_its_width() {
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
        /// Drops and immediate repeats only.
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

        #[test]
        fn any_counts_do_not_panic(counts in prop::collection::vec(any::<u16>(), 0..2000)) {
            totals_of(counts);
        }
    }
}
