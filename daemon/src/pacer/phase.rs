//! Phase lock: ticks come when the frames do, instead of at any time in between.
//!
//! ```text
//!  stamp          arrival
//!    │ ◀─── lag ────▶│               lag: the median time from a frame's stamp to its arrival
//!    └───────────────┼────────────────── next stamp
//!             awake ┌┼────────┐ latest
//!                   └┴────────┘      the tick looks for the frame, and begins when it is there
//!                    deadline
//! ```
//!
//! A free-running tick finds frames that are anything up to a frame period old. The lock watches when the frames of one
//! hand arrive, moves the deadlines by a few microseconds per tick until they fall on the arrivals, and says which payloads
//! the next tick should await: the frames of that hand, and what is captured together with them.
//!
//! * **In:** per tick how and when it began, and what had come by then. **Out:** by how much to move the next deadline, and
//!   what to await at it.
//! * **Invariants:** a deadline never moves by more than 5 µs or a two-hundredth of a period. Without new frames it does not
//!   move and nothing is awaited: the ticks go on by the timer. No clock is read here.
//! * **Absent on purpose:** sensors that send faster than the ticks gain nothing, their frames are young anyway.

use crate::ports::STREAMS;
use shm_schemas::capacity::HANDS;

use super::schedule::{Began, TickStart};

/// Largest move of one deadline, ns: half a percent of a 1 kHz period, far below what a motion could show. Ours.
const SLEW_MAX_NS: u64 = 5_000;
/// The same as a fraction of the period, for higher rates.
const SLEW_PERIODS: u64 = 200;
/// Share of the phase error that one frame corrects. Smaller: slow to lock. Larger: the ticks follow the jitter of the
/// stamps. Ours.
const GAIN: i64 = 8;
/// Largest step of the lag after one frame, ns, and the share of a smaller error that is taken. Together they make it
/// Huber's estimate of the middle: as fine as a mean where arrivals scatter by a few µs, as robust as a median against a
/// sensor process that is starved for milliseconds. Ours.
const LAG_STEP_NS: i64 = 1_000;
const LAG_GAIN: i64 = 16;
/// Longest lag, periods: the slowest way from a sensor to the bus that is worth following. Ours.
const LAG_MAX_PERIODS: u64 = 5;
/// Silence after which another hand's frames are followed, ns: half of the age at which frames are refused. Ours.
const SILENT_NS: u64 = 50_000_000;
/// Phase error below which the ticks count as locked, as a fraction of the period. Ours.
const LOCKED_PERIODS: i64 = 20;
/// Ticks that may await a frame in vain, one after the other, before none is awaited until the next one has come: a lost
/// sensor costs three waits, not a core. Ours.
const VAIN_MAX: u32 = 3;
/// Stamps that lie closer together than this fraction of a period belong together and are awaited together. Ours.
const TOGETHER_PERIODS: u64 = 20;
/// Share of a new distance between stamps in the estimate of the frame period. Ours.
const FRAME_PERIOD_GAIN: u64 = 8;

/// The state of the lock.
#[derive(Clone, Copy, Debug)]
pub struct PhaseLock {
    period_ns: u64,
    lag_ns: u64,
    /// What is left of the last correction, ns.
    rest_ns: i64,
    error_ns: i64,
    leader: Option<Leader>,
    /// Streams that are captured together with the leader's, and the leader's own.
    together: [bool; STREAMS],
    last_tick_ns: u64,
}

/// What is known of one stream after a tick.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Arrivals {
    /// Stamp of the newest believed payload, ns.
    pub captured_ns: u64,
    /// Payloads that arrived since the tick before.
    pub count: u32,
}

/// What a tick awaits: a stamp not older than this of each stream, ns; `None` where nothing is awaited.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub struct Awaited {
    /// Of every stream.
    pub least_captured_ns: [Option<u64>; STREAMS],
}

impl Awaited {
    /// Whether anything is awaited.
    #[must_use]
    pub fn is_something(&self) -> bool {
        self.least_captured_ns.iter().any(Option::is_some)
    }

    /// The streams of which it has not come, by the newest stamps.
    #[must_use]
    pub fn missing(&self, captured_ns: &[u64; STREAMS]) -> [bool; STREAMS] {
        core::array::from_fn(|stream| {
            self.least_captured_ns[stream].is_some_and(|least| captured_ns[stream] < least)
        })
    }
}

/// The hand whose frames are followed.
#[derive(Clone, Copy, Debug)]
struct Leader {
    hand: usize,
    captured_ns: u64,
    received_ns: u64,
    frame_period_ns: u64,
    vain: u32,
}

impl PhaseLock {
    /// A lock for ticks of this period (not 0) whose frames arrive about `lag_ns` after their stamps.
    #[must_use]
    pub fn new(period_ns: u64, lag_ns: u64) -> Self {
        Self {
            period_ns,
            lag_ns,
            rest_ns: 0,
            error_ns: 0,
            leader: None,
            together: [false; STREAMS],
            last_tick_ns: 0,
        }
    }

    /// Learns from a tick, and says by how much to move the next deadline, ns. `streams` is what came of the left hand, the
    /// right hand and the joints; `None` for one that never sent.
    pub fn correct(&mut self, start: &TickStart, streams: [Option<Arrivals>; STREAMS]) -> i64 {
        if let Some((oldest_ns, newest_ns)) = self.follow(start, streams) {
            self.learn_lag(oldest_ns, start);
            self.learn_phase(start.deadline_ns, newest_ns);
        }
        self.learn_together(streams);
        self.last_tick_ns = start.tick.now_ns;
        let most_ns = SLEW_MAX_NS.min(self.period_ns / SLEW_PERIODS).cast_signed();
        let move_ns = self.rest_ns.clamp(-most_ns, most_ns);
        self.rest_ns -= move_ns;
        move_ns
    }

    /// What the tick with this deadline should await: nothing unless a frame is due at it.
    #[must_use]
    pub fn awaited(&self, deadline_ns: u64) -> Awaited {
        let Some(leader) = self.leader.filter(|leader| leader.vain < VAIN_MAX) else {
            return Awaited::default();
        };
        // The frame whose arrival lies nearest to the deadline.
        let target_ns = deadline_ns.saturating_sub(self.lag_ns);
        let since_ns = target_ns.saturating_sub(leader.captured_ns);
        let frame_ns = leader.frame_period_ns;
        let frames = ((since_ns + frame_ns / 2) / frame_ns).max(1);
        let stamp_ns = leader
            .captured_ns
            .saturating_add(frames.saturating_mul(frame_ns));
        if !self.is_led(deadline_ns) || stamp_ns.abs_diff(target_ns) > self.period_ns / 2 {
            return Awaited::default();
        }
        let least_ns = stamp_ns - frame_ns.min(self.period_ns) / 2;
        Awaited {
            least_captured_ns: self.together.map(|is| is.then_some(least_ns)),
        }
    }

    /// Whether the ticks run where they should, after frames that still come.
    #[must_use]
    pub fn is_locked(&self) -> bool {
        let close_ns = self.period_ns.cast_signed() / LOCKED_PERIODS;
        self.is_led(self.last_tick_ns) && self.error_ns.abs() <= close_ns
    }

    /// The median time from a frame's stamp to its arrival, ns.
    #[must_use]
    pub fn lag_ns(&self) -> u64 {
        self.lag_ns
    }

    fn is_led(&self, now_ns: u64) -> bool {
        self.leader
            .is_some_and(|leader| now_ns.saturating_sub(leader.received_ns) < SILENT_NS)
    }

    /// The stamps of the oldest and the newest frame of the leader that arrived since the tick before, if any did. Left
    /// leads before right; a silent leader is replaced.
    fn follow(
        &mut self,
        start: &TickStart,
        streams: [Option<Arrivals>; STREAMS],
    ) -> Option<(u64, u64)> {
        let now_ns = start.tick.now_ns;
        if !self.is_led(now_ns) {
            let sends = |hand: &Arrivals| now_ns.saturating_sub(hand.captured_ns) < SILENT_NS;
            let hand = (0..HANDS).find(|hand| streams[*hand].as_ref().is_some_and(sends))?;
            self.leader = Some(Leader {
                hand,
                captured_ns: 0,
                received_ns: now_ns,
                frame_period_ns: self.period_ns,
                vain: 0,
            });
        }
        let leader = self.leader.as_mut()?;
        if start.began == Began::InVain {
            leader.vain += 1;
        }
        let hand = streams[leader.hand]?;
        if hand.captured_ns == leader.captured_ns {
            return None;
        }
        let steps = u64::from(hand.count.max(1));
        let since_ns = hand.captured_ns.saturating_sub(leader.captured_ns);
        let oldest_ns = hand.captured_ns - since_ns / steps * (steps - 1);
        if leader.captured_ns != 0 {
            leader.learn_frame_period(since_ns / steps);
        }
        (leader.captured_ns, leader.received_ns) = (hand.captured_ns, now_ns);
        if start.began != Began::InVain {
            leader.vain = 0;
        }
        Some((oldest_ns, hand.captured_ns))
    }

    /// Streams whose newest stamps lie at the leader's.
    fn learn_together(&mut self, streams: [Option<Arrivals>; STREAMS]) {
        let Some(leader) = self.leader else { return };
        let close_ns = self.period_ns / TOGETHER_PERIODS;
        self.together = streams.map(|stream| {
            stream.is_some_and(|s| s.captured_ns.abs_diff(leader.captured_ns) <= close_ns)
        });
    }

    /// A frame that came while it was looked for shows its lag. One that waited came earlier; one that the tick before ran
    /// without, a lag after its stamp, came later.
    fn learn_lag(&mut self, captured_ns: u64, start: &TickStart) {
        let due_ns = captured_ns.saturating_add(self.lag_ns);
        let is_late = due_ns <= self.last_tick_ns.saturating_add(SLEW_MAX_NS);
        let step_ns = if is_late {
            LAG_STEP_NS
        } else {
            match start.began {
                Began::OnArrival => {
                    let error_ns = start.tick.now_ns.wrapping_sub(due_ns).cast_signed();
                    (error_ns / LAG_GAIN).clamp(-LAG_STEP_NS, LAG_STEP_NS)
                }
                Began::FoundWaiting | Began::AtDeadline => -LAG_STEP_NS,
                Began::InVain => 0,
            }
        };
        let most_ns = LAG_MAX_PERIODS * self.period_ns;
        self.lag_ns = self.lag_ns.saturating_add_signed(step_ns).min(most_ns);
    }

    /// The error counts modulo the period, to the nearer side: which of two ticks takes a frame makes no difference.
    fn learn_phase(&mut self, deadline_ns: u64, captured_ns: u64) {
        let period_ns = self.period_ns.cast_signed();
        let age_ns = deadline_ns.wrapping_sub(captured_ns).cast_signed();
        let ahead_ns = (self.lag_ns.cast_signed())
            .wrapping_sub(age_ns)
            .rem_euclid(period_ns);
        self.error_ns = if 2 * ahead_ns > period_ns {
            ahead_ns - period_ns
        } else {
            ahead_ns
        };
        self.rest_ns = self.error_ns / GAIN;
    }
}

impl Leader {
    fn learn_frame_period(&mut self, observed_ns: u64) {
        let old_ns = self.frame_period_ns;
        let bounded_ns = observed_ns.clamp(old_ns / 2, old_ns.saturating_mul(2));
        let new_ns = old_ns - old_ns / FRAME_PERIOD_GAIN + bounded_ns / FRAME_PERIOD_GAIN;
        self.frame_period_ns = new_ns.max(1_000);
    }
}

#[cfg(test)]
mod tests;
