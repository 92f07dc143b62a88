use atas_core::Tick;
use proptest::prelude::*;

use super::*;

/// Time from the first poll to the deadline, and time limit after it.
const MARGIN_NS: u64 = 20_000;
const WAIT_MAX_NS: u64 = 200_000;

/// Simulated sensor and the ticks that follow it. Joint states arrive with the frames.
struct Scene {
    lock: PhaseLock,
    period_ns: u64,
    deadline_ns: u64,
    /// Stamp and arrival of frames in transit, oldest first.
    frames: Vec<(u64, u64)>,
    newest_ns: u64,
    next_stamp_ns: u64,
    sensor_period_ns: u64,
    seed: u64,
}

impl Scene {
    fn new(period_ns: u64, sensor_period_ns: u64, phase_ns: u64, lag_ns: u64) -> Self {
        let start_ns = 1_000_000_000;
        Self {
            lock: PhaseLock::new(period_ns, lag_ns),
            period_ns,
            deadline_ns: start_ns,
            frames: Vec::new(),
            newest_ns: 0,
            next_stamp_ns: start_ns + phase_ns,
            sensor_period_ns,
            seed: phase_ns,
        }
    }

    /// Xorshift random number below `below` (not 0).
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

    /// Runs one tick; frames take `delay_ns` plus up to `jitter_ns` from stamp to arrival.
    fn tick(&mut self, delay_ns: u64, jitter_ns: u64, sends: bool) -> TickResult {
        let patience_ns = WAIT_MAX_NS.min(self.period_ns / 4);
        let latest_ns = self.deadline_ns + patience_ns;
        while self.next_stamp_ns <= latest_ns {
            if sends {
                let arrival_ns = self.next_stamp_ns + delay_ns + self.random(jitter_ns + 1);
                self.frames.push((self.next_stamp_ns, arrival_ns));
            }
            self.next_stamp_ns += self.sensor_period_ns;
        }
        let awaited = self.lock.awaited(self.deadline_ns);
        let (now_ns, began) = self.begin(&awaited, latest_ns);
        let arrived = self.frames.iter().take_while(|(_, at)| *at <= now_ns);
        let count = arrived.count();
        if let Some((stamp_ns, _)) = self.frames.drain(..count).next_back() {
            self.newest_ns = stamp_ns;
        }
        let stream = Some(Arrivals {
            captured_ns: self.newest_ns,
            count: count as u32,
        });
        let start = TickStart {
            tick: Tick { index: 0, now_ns },
            deadline_ns: self.deadline_ns,
            reason: began,
            ..TickStart::default()
        };
        let move_ns = self.lock.update(&start, [None, stream, stream]);
        self.deadline_ns = (self.deadline_ns + self.period_ns).strict_add_signed(move_ns);
        TickResult {
            age_ns: now_ns - self.newest_ns,
            reason: began,
        }
    }

    fn begin(&self, awaited: &Awaited, latest_ns: u64) -> (u64, StartReason) {
        if !awaited.is_any() {
            return (self.deadline_ns, StartReason::AtDeadline);
        }
        let first_look_ns = self.deadline_ns - MARGIN_NS;
        let known = (self.newest_ns, 0);
        let mut came = std::iter::once(&known).chain(&self.frames);
        let found = came
            .find(|(stamp_ns, _)| awaited.missing(&[0, *stamp_ns, *stamp_ns]) == [false; STREAMS]);
        match found {
            Some((_, at)) if *at <= first_look_ns => (first_look_ns, StartReason::AlreadyArrived),
            Some((_, at)) if *at <= latest_ns => (*at, StartReason::OnArrival),
            _ => (latest_ns, StartReason::TimedOut),
        }
    }
}

struct TickResult {
    age_ns: u64,
    reason: StartReason,
}

fn percentile(mut ages_ns: Vec<u64>, share: f64) -> u64 {
    ages_ns.sort_unstable();
    ages_ns[(ages_ns.len() as f64 * share) as usize]
}

fn check_converges(period_ns: u64, phase_ns: u64, lag_ns: u64, delay_ns: u64, jitter_ns: u64) {
    let mut scene = Scene::new(period_ns, period_ns, phase_ns, lag_ns);
    scene.run(4_000, delay_ns, jitter_ns, true);
    let ages_ns: Vec<u64> = (0..4_000)
        .map(|_| scene.tick(delay_ns, jitter_ns, true).age_ns)
        .collect();
    let (p50, p99) = (percentile(ages_ns.clone(), 0.5), percentile(ages_ns, 0.99));
    let middle_ns = delay_ns + jitter_ns / 2;
    assert!(p50 <= middle_ns + 5_000, "p50 {p50} of {middle_ns} ns");
    let last_ns = delay_ns + jitter_ns;
    assert!(p99 <= last_ns + 5_000, "p99 {p99} of {last_ns} ns");
    assert!(scene.lock.is_locked());
}

#[test]
fn lag_of_several_periods_converges() {
    check_converges(1_000_000, 300_000, 2_250_000, 2_300_000, 10_000);
}

#[test]
fn large_jitter_is_met_on_arrival() {
    // A lag of the latest frame would age all frames; a tick at the median would miss every other
    // frame by a period.
    check_converges(1_000_000, 100_000, 40_000, 80_000, 150_000);
}

#[test]
fn delayed_sensor_process_keeps_the_lag() {
    let mut scene = Scene::new(1_000_000, 1_000_000, 0, 40_000);
    let mut ages_ns = Vec::new();
    for tick in 0..100_000 {
        let starved = tick % 100 == 0;
        let seen = scene.tick(if starved { 5_000_000 } else { 50_000 }, 5_000, true);
        if tick > 5_000 {
            ages_ns.push(seen.age_ns);
        }
    }
    let lag_ns = scene.lock.lag_ns();
    assert!((45_000..60_000).contains(&lag_ns), "{lag_ns} ns");
    assert!(scene.lock.is_locked());
    // Frames arrive in order: a delayed one also delays the next four.
    let p90 = percentile(ages_ns, 0.9);
    assert!(p90 < 60_000, "{p90} ns");
}

#[test]
fn late_frame_does_not_delay_the_next() {
    let mut scene = Scene::new(1_000_000, 1_000_000, 0, 50_000);
    scene.run(3_000, 50_000, 0, true);
    let late = scene.tick(700_000, 0, true);
    assert_eq!(late.reason, StartReason::TimedOut);
    for _ in 0..10 {
        let seen = scene.tick(50_000, 0, true);
        assert!(seen.age_ns < 60_000, "{} ns", seen.age_ns);
    }
}

#[test]
fn slow_sensor_is_awaited_only_when_due() {
    let mut scene = Scene::new(1_000_000, 10_000_000, 432_100, 30_000);
    scene.run(20_000, 50_000, 0, true);
    let seen: Vec<TickResult> = (0..1_000).map(|_| scene.tick(50_000, 0, true)).collect();
    let youngest = seen.iter().map(|seen| seen.age_ns).min();
    assert!(
        youngest.is_some_and(|age_ns| age_ns <= 55_000),
        "{youngest:?}"
    );
    let count = |began| seen.iter().filter(|seen| seen.reason == began).count();
    assert_eq!(count(StartReason::TimedOut), 0);
    assert_eq!(count(StartReason::AtDeadline), 900);
}

#[test]
fn lost_sensor_is_awaited_three_times() {
    let mut scene = Scene::new(1_000_000, 1_000_000, 0, 50_000);
    scene.run(3_000, 50_000, 0, true);
    let silent: Vec<TickResult> = (0..100).map(|_| scene.tick(50_000, 0, false)).collect();
    let vain = silent
        .iter()
        .filter(|seen| seen.reason == StartReason::TimedOut);
    assert_eq!(vain.count(), TIMEOUTS_MAX as usize);
    scene.run(3_000, 50_000, 0, true);
    assert_eq!(scene.tick(50_000, 0, true).reason, StartReason::OnArrival);
}

#[test]
fn silent_simultaneous_stream_is_awaited_once() {
    let mut lock = PhaseLock::new(1_000_000, 50_000);
    let mut deadline_ns = 1_000_050_000_u64;
    let mut tick = |lock: &mut PhaseLock, joints_come: bool| {
        deadline_ns += 1_000_000;
        let awaited = lock.awaited(deadline_ns);
        let came = |captured_ns| {
            Some(Arrivals {
                captured_ns,
                count: 1,
            })
        };
        let stamp_ns = deadline_ns - 50_000;
        let joints = came(if joints_come { stamp_ns } else { 1_000_000_000 });
        let start = TickStart {
            tick: Tick {
                index: 0,
                now_ns: deadline_ns,
            },
            deadline_ns,
            ..TickStart::default()
        };
        lock.update(&start, [came(stamp_ns), None, joints]);
        awaited.captured_min_ns.map(|least| least.is_some())
    };
    tick(&mut lock, true);
    tick(&mut lock, true);
    assert_eq!(tick(&mut lock, true), [true, false, true]);
    assert_eq!(tick(&mut lock, false), [true, false, true]);
    assert_eq!(tick(&mut lock, false), [true, false, false]);
}

#[test]
fn silent_reference_is_replaced_by_other_hand() {
    let mut lock = PhaseLock::new(1_000_000, 0);
    let mut now_ns = 1_000_000_000;
    let mut tick = |lock: &mut PhaseLock, captured_ns: [u64; 2]| {
        now_ns += 1_000_000;
        let [left, right] = captured_ns.map(|captured_ns| {
            (captured_ns != 0).then_some(Arrivals {
                captured_ns,
                count: 1,
            })
        });
        let start = TickStart {
            tick: Tick { index: 0, now_ns },
            deadline_ns: now_ns,
            ..TickStart::default()
        };
        lock.update(&start, [left, right, None])
    };
    let left_ns = 1_000_700_000;
    assert_ne!(tick(&mut lock, [left_ns, 0]), 0);
    // The correction of that frame ends, then nothing shifts.
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
    fn shift_is_bounded_for_any_stamps(
        period_ns in 100_000_u64..10_000_000,
        ticks in proptest::collection::vec(
            (0_u64..20_000_000, proptest::array::uniform3(proptest::option::of((any::<u64>(), any::<u32>())))), 1..200),
        lag_ns in 0_u64..500_000,
    ) {
        let mut lock = PhaseLock::new(period_ns, lag_ns);
        let mut now_ns = 1_u64 << 40;
        for (pause_ns, streams) in ticks {
            now_ns += pause_ns;
            let _awaited = lock.awaited(now_ns);
            let arrivals = |(captured_ns, count)| Arrivals { captured_ns, count };
            let streams = streams.map(|stream| stream.map(arrivals));
            let start = TickStart { tick: Tick { index: 0, now_ns }, deadline_ns: now_ns, ..TickStart::default() };
            let move_ns = lock.update(&start, streams);
            prop_assert!(move_ns.unsigned_abs() <= SHIFT_MAX_NS.min(period_ns / SHIFT_MAX_DIVISOR));
        }
    }

    #[test]
    fn lock_recovers_after_gaps(phase_ns in 0_u64..1_000_000, gaps in proptest::collection::vec((1_usize..300, 1_usize..300), 1..6)) {
        let mut scene = Scene::new(1_000_000, 1_000_000, phase_ns, 20_000);
        for (sent, lost) in gaps {
            scene.run(sent, 30_000, 5_000, true);
            scene.run(lost, 30_000, 5_000, false);
        }
        scene.run(2_000, 30_000, 5_000, true);
        let age_ns = scene.tick(30_000, 5_000, true).age_ns;
        prop_assert!(scene.lock.is_locked(), "age {age_ns} ns");
        prop_assert!(age_ns < 40_000, "age {age_ns} ns");
    }
}
