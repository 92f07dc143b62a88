//! Phase lock: ticks come shortly after the frames they need, instead of at any time in between.
//!
//! ```text
//!  stamp        arrival
//!    │ ◀── lag ───▶│tick      lag: least at first, more when frames come later than it, less when all come in time
//!    └─────────────┴┴──────────────── next stamp
//! ```
//!
//! A free-running tick finds frames that are anything up to a frame period old. The lock watches how long after the stamp
//! of the followed hand's frames the ticks run, and moves the deadlines by a few microseconds per tick until that is
//! `lag`.
//!
//! * **In:** per tick its deadline, its time, and what arrived of each hand. **Out:** by how much to move the
//!   next deadline.
//! * **Invariants:** a deadline never moves by more than 5 µs or a two-hundredth of a period. Without new
//!   frames it does not move: the ticks go on by the timer. No clock is read here.
//! * **Absent on purpose:** sensors that send faster than the ticks gain nothing, their frames are young anyway.

use atas_core::Tick;
use shm_schemas::capacity::HANDS;

/// Largest move of one deadline, ns: half a percent of a 1 kHz period, far below what a motion could show. Ours.
const SLEW_MAX_NS: u64 = 5_000;
/// The same as a fraction of the period, for higher rates.
const SLEW_PERIODS: u64 = 200;
/// Share of the phase error that one frame corrects. Smaller: slow to lock. Larger: the ticks follow the jitter of the
/// stamps. Ours.
const GAIN: i64 = 8;
/// How much the lag grows after a frame that came late, and which part of its excess goes after one that came in time.
/// The two meet where the share of late frames is the excess over `UP × LEAK` = 8 ms: 0.5 % for 40 µs. A quantile would be
/// simpler, but a sensor process that is starved for milliseconds every hundred frames would drive it away for ever. Ours.
const UP_NS: u64 = 1_000;
const LEAK: u64 = 8_192;
/// Longest lag, periods: the slowest way from a sensor to the bus that is worth following. Ours.
const LAG_MAX_PERIODS: u64 = 5;
/// Silence after which another hand's frames are followed, ns: half of the age at which frames are refused. Ours.
const SILENT_NS: u64 = 50_000_000;
/// Phase error below which the ticks count as locked, as a fraction of the period. Ours.
const LOCKED_PERIODS: i64 = 20;

/// The state of the lock.
#[derive(Clone, Copy, Debug)]
pub struct PhaseLock {
    period_ns: u64,
    least_ns: u64,
    lag_ns: u64,
    /// What is left of the last correction, ns.
    rest_ns: i64,
    error_ns: i64,
    leader: Option<Leader>,
    last_tick_ns: u64,
}

/// What is known of one hand's frames after a tick.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Arrivals {
    /// Stamp of the newest believed frame, ns.
    pub captured_ns: u64,
    /// Frames that arrived since the tick before.
    pub frames: u32,
}

/// The hand whose frames are followed.
#[derive(Clone, Copy, Debug)]
struct Leader {
    hand: usize,
    captured_ns: u64,
    heard_ns: u64,
}

impl PhaseLock {
    /// A lock for ticks of this period (not 0) that shall run at least `least_ns` after the stamps.
    #[must_use]
    pub fn new(period_ns: u64, least_ns: u64) -> Self {
        Self {
            period_ns,
            least_ns,
            lag_ns: least_ns,
            rest_ns: 0,
            error_ns: 0,
            leader: None,
            last_tick_ns: 0,
        }
    }

    /// Learns from a tick, and says by how much to move the next deadline, ns. `deadline_ns` is when the tick was due,
    /// `hands` what arrived, `None` for a hand that never sent.
    pub fn correct(
        &mut self,
        tick: Tick,
        deadline_ns: u64,
        hands: [Option<Arrivals>; HANDS],
    ) -> i64 {
        if let Some((oldest_ns, newest_ns)) = self.follow(tick.now_ns, hands) {
            self.learn_lag(oldest_ns);
            self.learn_phase(deadline_ns, newest_ns);
        }
        self.last_tick_ns = tick.now_ns;
        let most_ns = SLEW_MAX_NS.min(self.period_ns / SLEW_PERIODS).cast_signed();
        let move_ns = self.rest_ns.clamp(-most_ns, most_ns);
        self.rest_ns -= move_ns;
        move_ns
    }

    /// Whether the ticks run where they should, after frames that still come.
    #[must_use]
    pub fn is_locked(&self) -> bool {
        let close_ns = self.period_ns.cast_signed() / LOCKED_PERIODS;
        self.is_led(self.last_tick_ns) && self.error_ns.abs() <= close_ns
    }

    /// How long after a frame's stamp the ticks shall run, ns.
    #[must_use]
    pub fn lag_ns(&self) -> u64 {
        self.lag_ns
    }

    fn is_led(&self, now_ns: u64) -> bool {
        self.leader
            .is_some_and(|leader| now_ns.saturating_sub(leader.heard_ns) < SILENT_NS)
    }

    /// The stamps of the oldest and the newest frame of the leader that arrived since the tick before, if any did. Left
    /// leads before right; a silent leader is replaced.
    fn follow(&mut self, now_ns: u64, hands: [Option<Arrivals>; HANDS]) -> Option<(u64, u64)> {
        if !self.is_led(now_ns) {
            let sends = |hand: &Arrivals| now_ns.saturating_sub(hand.captured_ns) < SILENT_NS;
            let hand = (0..HANDS).find(|hand| hands[*hand].as_ref().is_some_and(sends))?;
            self.leader = Some(Leader {
                hand,
                captured_ns: 0,
                heard_ns: now_ns,
            });
        }
        let leader = self.leader.as_mut()?;
        let hand = hands[leader.hand]?;
        if hand.captured_ns == leader.captured_ns {
            return None;
        }
        let steps = u64::from(hand.frames.max(1));
        let since_ns = hand.captured_ns.saturating_sub(leader.captured_ns);
        let oldest_ns = hand.captured_ns - since_ns / steps * (steps - 1);
        (leader.captured_ns, leader.heard_ns) = (hand.captured_ns, now_ns);
        Some((oldest_ns, hand.captured_ns))
    }

    /// A frame is late if the tick before ran a lag after its stamp and did not find it.
    fn learn_lag(&mut self, captured_ns: u64) {
        let due_ns = captured_ns.saturating_add(self.lag_ns);
        let is_late = due_ns <= self.last_tick_ns.saturating_add(SLEW_MAX_NS);
        let excess_ns = self.lag_ns - self.least_ns;
        let most_ns = (LAG_MAX_PERIODS * self.period_ns).saturating_sub(self.least_ns);
        let excess_ns = if is_late {
            (excess_ns + UP_NS).min(most_ns)
        } else {
            excess_ns - excess_ns.div_ceil(LEAK)
        };
        self.lag_ns = self.least_ns + excess_ns;
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

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// A sensor and the ticks that follow it, in simulated time.
    struct Scene {
        lock: PhaseLock,
        period_ns: u64,
        deadline_ns: u64,
        /// Stamp and arrival of the frames that are under way, oldest first.
        frames: Vec<(u64, u64)>,
        newest_ns: u64,
        next_stamp_ns: u64,
        sensor_period_ns: u64,
        seed: u64,
    }

    impl Scene {
        fn new(period_ns: u64, sensor_period_ns: u64, phase_ns: u64, least_ns: u64) -> Self {
            let start_ns = 1_000_000_000;
            Self {
                lock: PhaseLock::new(period_ns, least_ns),
                period_ns,
                deadline_ns: start_ns,
                frames: Vec::new(),
                newest_ns: 0,
                next_stamp_ns: start_ns + phase_ns,
                sensor_period_ns,
                seed: phase_ns,
            }
        }

        /// Xorshift: any number below `below` (not 0).
        fn random(&mut self, below: u64) -> u64 {
            self.seed = (self.seed ^ 0x9E37_79B9_7F4A_7C15).rotate_left(17);
            self.seed ^= self.seed << 7;
            self.seed ^= self.seed >> 9;
            self.seed % below
        }

        fn run(&mut self, ticks: usize, delay_ns: u64, jitter_ns: u64, sends: bool) {
            for _ in 0..ticks {
                self.tick(delay_ns, jitter_ns, sends);
            }
        }

        /// One tick; `delay_ns` from stamp to arrival plus up to `jitter_ns`. Returns the age of the newest frame that
        /// has arrived, and how far the next deadline moved.
        fn tick(&mut self, delay_ns: u64, jitter_ns: u64, sends: bool) -> (u64, i64) {
            while self.next_stamp_ns <= self.deadline_ns {
                if sends {
                    let arrival_ns = self.next_stamp_ns + delay_ns + self.random(jitter_ns + 1);
                    self.frames.push((self.next_stamp_ns, arrival_ns));
                }
                self.next_stamp_ns += self.sensor_period_ns;
            }
            let now_ns = self.deadline_ns;
            let arrived = self.frames.iter().take_while(|(_, at)| *at <= now_ns);
            let frames = arrived.count();
            if let Some((stamp_ns, _)) = self.frames.drain(..frames).next_back() {
                self.newest_ns = stamp_ns;
            }
            let hand = Arrivals {
                captured_ns: self.newest_ns,
                frames: frames as u32,
            };
            let tick = Tick { index: 0, now_ns };
            let move_ns = self.lock.correct(tick, now_ns, [None, Some(hand)]);
            self.deadline_ns = (now_ns + self.period_ns).strict_add_signed(move_ns);
            (now_ns - self.newest_ns, move_ns)
        }
    }

    fn percentile(mut ages_ns: Vec<u64>, share: f64) -> u64 {
        ages_ns.sort_unstable();
        ages_ns[(ages_ns.len() as f64 * share) as usize]
    }

    fn check_converges(
        period_ns: u64,
        phase_ns: u64,
        least_ns: u64,
        delay_ns: u64,
        jitter_ns: u64,
    ) {
        let mut scene = Scene::new(period_ns, period_ns, phase_ns, least_ns);
        scene.run(4_000, delay_ns, jitter_ns, true);
        let ages_ns: Vec<u64> = (0..4_000)
            .map(|_| scene.tick(delay_ns, jitter_ns, true).0)
            .collect();
        let needed_ns = (delay_ns + jitter_ns).max(least_ns);
        let (p50, p98) = (percentile(ages_ns.clone(), 0.5), percentile(ages_ns, 0.98));
        assert!(
            p50 <= needed_ns + 15_000,
            "p50 {p50} ns, needed {needed_ns} ns"
        );
        assert!(
            p98 <= needed_ns + 30_000,
            "p98 {p98} ns, needed {needed_ns} ns"
        );
        assert!(scene.lock.is_locked());
    }

    #[test]
    fn a_sensor_whose_way_takes_periods_is_followed_if_its_offset_is_set() {
        check_converges(1_000_000, 300_000, 2_250_000, 2_300_000, 10_000);
    }

    #[test]
    fn a_starved_sensor_process_does_not_drive_the_lag_away() {
        let mut scene = Scene::new(1_000_000, 1_000_000, 0, 40_000);
        for tick in 0..100_000 {
            let starved = tick % 100 == 0;
            scene.tick(if starved { 5_000_000 } else { 50_000 }, 5_000, true);
        }
        assert!(scene.lock.lag_ns() < 250_000, "{} ns", scene.lock.lag_ns());
        assert!(scene.lock.is_locked());
    }

    #[test]
    fn a_slow_sensor_is_followed() {
        let mut scene = Scene::new(1_000_000, 10_000_000, 432_100, 30_000);
        scene.run(20_000, 50_000, 0, true);
        let youngest = (0..10).map(|_| scene.tick(50_000, 0, true).0).min();
        assert!(
            youngest.is_some_and(|age_ns| age_ns <= 65_000),
            "{youngest:?}"
        );
    }

    #[test]
    fn silence_leaves_the_timer_alone_and_another_hand_takes_over() {
        let mut lock = PhaseLock::new(1_000_000, 0);
        let mut now_ns = 1_000_000_000;
        let mut tick = |lock: &mut PhaseLock, captured_ns: [u64; 2]| {
            now_ns += 1_000_000;
            let hands = captured_ns.map(|captured_ns| {
                (captured_ns != 0).then_some(Arrivals {
                    captured_ns,
                    frames: 1,
                })
            });
            lock.correct(Tick { index: 0, now_ns }, now_ns, hands)
        };
        let left_ns = 1_000_700_000;
        assert_ne!(tick(&mut lock, [left_ns, 0]), 0);
        // The correction of that frame runs out, then nothing moves.
        for _ in 0..20 {
            tick(&mut lock, [left_ns, 0]);
        }
        for _ in 0..40 {
            assert_eq!(tick(&mut lock, [left_ns, 0]), 0);
        }
        assert!(!lock.is_locked());
        assert_ne!(tick(&mut lock, [left_ns, 1_061_600_000]), 0);
    }

    proptest! {
        #[test]
        fn converges_from_any_phase(
            rate_hz in prop_oneof![Just(1000_u64), Just(500), Just(2000)],
            phase in 0.0..1.0_f64,
            delay_ns in 0_u64..100_000,
            jitter_ns in 0_u64..40_000,
        ) {
            let period_ns = 1_000_000_000 / rate_hz;
            check_converges(period_ns, (phase * period_ns as f64) as u64, 40_000, delay_ns, jitter_ns);
        }

        #[test]
        fn no_deadline_ever_jumps(
            period_ns in 100_000_u64..10_000_000,
            ticks in proptest::collection::vec(
                (0_u64..20_000_000, proptest::array::uniform2(proptest::option::of((any::<u64>(), any::<u32>())))), 1..200),
            least_ns in 0_u64..500_000,
        ) {
            let mut lock = PhaseLock::new(period_ns, least_ns);
            let mut now_ns = 1_u64 << 40;
            for (pause_ns, hands) in ticks {
                now_ns += pause_ns;
                let arrivals = |(captured_ns, frames)| Arrivals { captured_ns, frames };
                let hands = hands.map(|hand| hand.map(arrivals));
                let move_ns = lock.correct(Tick { index: 0, now_ns }, now_ns, hands);
                prop_assert!(move_ns.unsigned_abs() <= SLEW_MAX_NS.min(period_ns / SLEW_PERIODS));
                prop_assert!(lock.lag_ns() >= least_ns);
            }
        }

        #[test]
        fn survives_gaps(phase_ns in 0_u64..1_000_000, gaps in proptest::collection::vec((1_usize..300, 1_usize..300), 1..6)) {
            let mut scene = Scene::new(1_000_000, 1_000_000, phase_ns, 20_000);
            for (sent, lost) in gaps {
                scene.run(sent, 30_000, 5_000, true);
                scene.run(lost, 30_000, 5_000, false);
            }
            scene.run(2_000, 30_000, 5_000, true);
            let (age_ns, _) = scene.tick(30_000, 5_000, true);
            prop_assert!(scene.lock.is_locked(), "age {age_ns} ns");
        }
    }
}
