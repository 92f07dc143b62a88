//! Phase lock: aligns the ticks with the arrival of frames.
//!
//! ```text
//!  stamp          arrival
//!    │ ◀─── lag ────▶│               lag: median time from a frame's stamp to its arrival
//!    └───────────────┼────────────────── next stamp
//!             awake ┌┼────────┐ time limit
//!                   └┴────────┘      the tick polls for the frame and starts when it has arrived
//!                    deadline
//! ```
//!
//! Without the lock, a tick finds frames up to one frame period old. The lock measures when the
//! frames of one hand, the reference hand, arrive. It shifts the deadlines by a few microseconds
//! per tick to the arrivals. It also determines which payloads the next tick awaits: frames of that
//! hand, and streams captured at the same time.
//!
//! * **In:** per tick its start and the payloads received so far. **Out:** shift of the next
//!   deadline, payloads to await.
//! * **Invariants:** a shift is at most 5 µs and 1/200 of a period. Without new frames nothing
//!   shifts and nothing is awaited. No clock is read here.
//!
//! Sensors faster than the ticks gain nothing: their frames are always young.

use crate::ports::STREAMS;
use shm_schemas::capacity::HANDS;

use super::schedule::{StartReason, TickStart};

/// Maximum shift of one deadline, ns: 0.5 % of a 1 kHz period, invisible in the motion. Design
/// choice.
const SHIFT_MAX_NS: u64 = 5_000;
/// Limit as a divisor of the period, for higher rates.
const SHIFT_MAX_DIVISOR: u64 = 200;
/// Divisor of the phase error per frame. Larger: slow to lock. Smaller: ticks follow the jitter of
/// the stamps. Design choice.
const ERROR_DIVISOR: i64 = 8;
/// Maximum step of the lag per frame, ns, and divisor for smaller errors. Together a Huber
/// estimate: fine as a mean for a scatter of a few µs, robust as a median against a sensor process
/// delayed by milliseconds. Design choice.
const LAG_STEP_NS: i64 = 1_000;
const LAG_DIVISOR: i64 = 16;
/// Maximum lag, periods. Design choice.
const LAG_MAX_PERIODS: u64 = 5;
/// Silence after which another hand becomes the reference, ns: half the age at which frames are
/// rejected. Design choice.
const REFERENCE_TIMEOUT_NS: u64 = 50_000_000;
/// Phase error below which the ticks count as locked, as a divisor of the period. Design choice.
const LOCKED_DIVISOR: i64 = 20;
/// Consecutive time-outs after which no frame is awaited until one arrives: a lost sensor costs
/// three waits. Design choice.
const TIMEOUTS_MAX: u32 = 3;
/// Maximum difference of simultaneous stamps, as a divisor of the period; such streams are awaited
/// together. Design choice.
const SIMULTANEOUS_DIVISOR: u64 = 20;
/// Divisor of the filter of the frame period. Design choice.
const FRAME_PERIOD_DIVISOR: u64 = 8;

/// State of the phase lock.
#[derive(Clone, Copy, Debug)]
pub struct PhaseLock {
    period_ns: u64,
    lag_ns: u64,
    /// Remainder of the last correction, ns.
    remaining_ns: i64,
    error_ns: i64,
    reference: Option<ReferenceHand>,
    /// Streams captured together with the reference stream, itself included.
    simultaneous: [bool; STREAMS],
    last_tick_ns: u64,
}

/// Payloads of one stream at a tick.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Arrivals {
    /// Stamp of the newest accepted payload, ns.
    pub captured_ns: u64,
    /// Number of payloads since the previous tick.
    pub count: u32,
}

/// Minimum stamp that a tick awaits of each stream.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub struct Awaited {
    /// Minimum stamps, ns; `None` if the stream is not awaited.
    pub captured_min_ns: [Option<u64>; STREAMS],
}

impl Awaited {
    /// Returns true if any stream is awaited.
    #[must_use]
    pub fn is_any(&self) -> bool {
        self.captured_min_ns.iter().any(Option::is_some)
    }

    /// Awaited streams whose newest stamp is too old.
    #[must_use]
    pub fn missing(&self, captured_ns: &[u64; STREAMS]) -> [bool; STREAMS] {
        core::array::from_fn(|stream| {
            self.captured_min_ns[stream].is_some_and(|least| captured_ns[stream] < least)
        })
    }
}

/// Hand whose frames the ticks follow.
#[derive(Clone, Copy, Debug)]
struct ReferenceHand {
    hand: usize,
    captured_ns: u64,
    received_ns: u64,
    frame_period_ns: u64,
    timeouts: u32,
}

impl PhaseLock {
    /// A lock for ticks with this period (not 0) and frames that arrive about `lag_ns` after their
    /// stamps.
    #[must_use]
    pub fn new(period_ns: u64, lag_ns: u64) -> Self {
        Self {
            period_ns,
            lag_ns,
            remaining_ns: 0,
            error_ns: 0,
            reference: None,
            simultaneous: [false; STREAMS],
            last_tick_ns: 0,
        }
    }

    /// Updates the lock with a tick and returns the shift of the next deadline, ns. `streams`: left
    /// hand, right hand, joints; `None` if nothing was ever received.
    pub fn update(&mut self, start: &TickStart, streams: [Option<Arrivals>; STREAMS]) -> i64 {
        if let Some((oldest_ns, newest_ns)) = self.update_reference(start, streams) {
            self.estimate_lag(oldest_ns, start);
            self.compute_error(start.deadline_ns, newest_ns);
        }
        self.mark_simultaneous(streams);
        self.last_tick_ns = start.tick.now_ns;
        let most_ns = SHIFT_MAX_NS
            .min(self.period_ns / SHIFT_MAX_DIVISOR)
            .cast_signed();
        let move_ns = self.remaining_ns.clamp(-most_ns, most_ns);
        self.remaining_ns -= move_ns;
        move_ns
    }

    /// Stamps that the tick with this deadline awaits; none unless a frame is due.
    #[must_use]
    pub fn awaited(&self, deadline_ns: u64) -> Awaited {
        let Some(leader) = self
            .reference
            .filter(|leader| leader.timeouts < TIMEOUTS_MAX)
        else {
            return Awaited::default();
        };
        // Frame whose arrival is nearest to the deadline.
        let target_ns = deadline_ns.saturating_sub(self.lag_ns);
        let since_ns = target_ns.saturating_sub(leader.captured_ns);
        let frame_ns = leader.frame_period_ns;
        let frames = ((since_ns + frame_ns / 2) / frame_ns).max(1);
        let stamp_ns = leader
            .captured_ns
            .saturating_add(frames.saturating_mul(frame_ns));
        if !self.has_reference(deadline_ns) || stamp_ns.abs_diff(target_ns) > self.period_ns / 2 {
            return Awaited::default();
        }
        let least_ns = stamp_ns - frame_ns.min(self.period_ns) / 2;
        Awaited {
            captured_min_ns: self.simultaneous.map(|is| is.then_some(least_ns)),
        }
    }

    /// Returns true if frames still arrive and the phase error is small.
    #[must_use]
    pub fn is_locked(&self) -> bool {
        let close_ns = self.period_ns.cast_signed() / LOCKED_DIVISOR;
        self.has_reference(self.last_tick_ns) && self.error_ns.abs() <= close_ns
    }

    /// Median time from a frame's stamp to its arrival, ns.
    #[must_use]
    pub fn lag_ns(&self) -> u64 {
        self.lag_ns
    }

    fn has_reference(&self, now_ns: u64) -> bool {
        self.reference
            .is_some_and(|leader| now_ns.saturating_sub(leader.received_ns) < REFERENCE_TIMEOUT_NS)
    }

    /// Stamps of the oldest and newest frame of the reference hand since the previous tick, if any.
    /// The left hand has priority; a silent reference is replaced.
    fn update_reference(
        &mut self,
        start: &TickStart,
        streams: [Option<Arrivals>; STREAMS],
    ) -> Option<(u64, u64)> {
        let now_ns = start.tick.now_ns;
        if !self.has_reference(now_ns) {
            let sends =
                |hand: &Arrivals| now_ns.saturating_sub(hand.captured_ns) < REFERENCE_TIMEOUT_NS;
            let hand = (0..HANDS).find(|hand| streams[*hand].as_ref().is_some_and(sends))?;
            self.reference = Some(ReferenceHand {
                hand,
                captured_ns: 0,
                received_ns: now_ns,
                frame_period_ns: self.period_ns,
                timeouts: 0,
            });
        }
        let leader = self.reference.as_mut()?;
        if start.reason == StartReason::TimedOut {
            leader.timeouts += 1;
        }
        let hand = streams[leader.hand]?;
        if hand.captured_ns == leader.captured_ns {
            return None;
        }
        let steps = u64::from(hand.count.max(1));
        let since_ns = hand.captured_ns.saturating_sub(leader.captured_ns);
        let oldest_ns = hand.captured_ns - since_ns / steps * (steps - 1);
        if leader.captured_ns != 0 {
            leader.filter_frame_period(since_ns / steps);
        }
        (leader.captured_ns, leader.received_ns) = (hand.captured_ns, now_ns);
        if start.reason != StartReason::TimedOut {
            leader.timeouts = 0;
        }
        Some((oldest_ns, hand.captured_ns))
    }

    /// Marks the streams whose newest stamp is close to the reference's.
    fn mark_simultaneous(&mut self, streams: [Option<Arrivals>; STREAMS]) {
        let Some(leader) = self.reference else { return };
        let close_ns = self.period_ns / SIMULTANEOUS_DIVISOR;
        self.simultaneous = streams.map(|stream| {
            stream.is_some_and(|s| s.captured_ns.abs_diff(leader.captured_ns) <= close_ns)
        });
    }

    /// Estimates the lag. A frame that arrived during polling shows its lag. A waiting frame
    /// arrived earlier, a frame missing at the previous tick later.
    fn estimate_lag(&mut self, captured_ns: u64, start: &TickStart) {
        let due_ns = captured_ns.saturating_add(self.lag_ns);
        let is_late = due_ns <= self.last_tick_ns.saturating_add(SHIFT_MAX_NS);
        let step_ns = if is_late {
            LAG_STEP_NS
        } else {
            match start.reason {
                StartReason::OnArrival => {
                    let error_ns = start.tick.now_ns.wrapping_sub(due_ns).cast_signed();
                    (error_ns / LAG_DIVISOR).clamp(-LAG_STEP_NS, LAG_STEP_NS)
                }
                StartReason::AlreadyArrived | StartReason::AtDeadline => -LAG_STEP_NS,
                StartReason::TimedOut => 0,
            }
        };
        let most_ns = LAG_MAX_PERIODS * self.period_ns;
        self.lag_ns = self.lag_ns.saturating_add_signed(step_ns).min(most_ns);
    }

    /// Computes the error modulo the period, to the nearer side: it does not matter which tick
    /// takes a frame.
    fn compute_error(&mut self, deadline_ns: u64, captured_ns: u64) {
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
        self.remaining_ns = self.error_ns / ERROR_DIVISOR;
    }
}

impl ReferenceHand {
    fn filter_frame_period(&mut self, observed_ns: u64) {
        let old_ns = self.frame_period_ns;
        let bounded_ns = observed_ns.clamp(old_ns / 2, old_ns.saturating_mul(2));
        let new_ns = old_ns - old_ns / FRAME_PERIOD_DIVISOR + bounded_ns / FRAME_PERIOD_DIVISOR;
        self.frame_period_ns = new_ns.max(1_000);
    }
}

#[cfg(test)]
mod tests;
