//! Benchmark: 1,000 robots at 1 kHz on the bus. This process hosts 250 fields of four;
//! `ebts agents` looks up their tables.
//!
//! A frame is missed if its answer does not arrive before the next frame is due. The benchmark
//! prints missed frames and the time from publishing the sensor rows to receiving the wheel
//! commands. Every answer is compared with the table.
//!
//! Missed frames are attributed to other programs if both processes waited for a core for more than
//! half of the gap. An answer takes a small part of the other half.
//!
//! `cargo bench -p ebts --bench bus`; with `chrt -f 50` in front, both processes run with real-time
//! priority.
#![expect(clippy::print_stdout, reason = "output of the benchmark")]

use std::process::{Child, Command, Stdio};

use ebts::agents::Lookup;
use ebts::built_in;
use field::{MAX_AGENTS, TrialRun, Wheels};
use hdrhistogram::Histogram;
use rustix::thread::clock_nanosleep_absolute;
use rustix::time::{ClockId, Timespec};
use shm_bus::{Bus, FreshBus, Publisher, Realtime, Subscriber, now_ns, writer_epoch};
use shm_schemas::{AgentSensors, WheelCommands, service};

const FIELDS: usize = 250;
const TEAM: usize = MAX_AGENTS;
const PERIOD_NS: u64 = 1_000_000;
/// Frames: 30 s as a benchmark, 0.2 s as a test.
const FRAMES: [u64; 2] = [30_000, 200];
/// Frames before the measurement, in which new processes map each other's memory.
const WARM_UP: u64 = 100;
/// Longest wait for the start of the agents process, ns.
const START_NS: u64 = 20_000_000_000;

struct Agents(Child);

impl Drop for Agents {
    fn drop(&mut self) {
        // The process may have ended already.
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// Consecutive missed frames. Their cause is known only after the next answer, because waiting time
/// is counted at its end.
struct Gap {
    since_ns: u64,
    waited_before_ns: u64,
    missed: u64,
}

/// Returns the time that this process and `agents` were ready to run without a core, ns; 0 if the
/// kernel does not report it.
fn waited_ns(agents: &Agents) -> u64 {
    let waited = |process: &str| {
        let text = std::fs::read_to_string(format!("/proc/{process}/schedstat")).ok()?;
        text.split_whitespace().nth(1)?.parse::<u64>().ok()
    };
    waited("self").unwrap_or(0) + waited(&agents.0.id().to_string()).unwrap_or(0)
}

struct Host {
    fields: Vec<TrialRun>,
    lookup: Lookup,
    publisher: Publisher<AgentSensors>,
    subscriber: Subscriber<WheelCommands>,
    sensors: AgentSensors,
    commands: WheelCommands,
}

impl Host {
    fn open(bus: &Bus) -> Self {
        let file = built_in::table("r3-two-agents").expect("built in");
        let model = &file.condition.model;
        let team = field::TeamSize::new(TEAM).expect("a team");
        let layout = |f: usize| model.training_layout(model.goal_towards((f % 64) as u8));
        let fields = (0..FIELDS).map(|f| TrialRun::new(model, team, &layout(f)));
        let mut sensors = AgentSensors::default();
        sensors.stamp.writer_epoch = writer_epoch();
        sensors.agent_count = (FIELDS * TEAM) as u32;
        sensors.field_hash = model.preset().fingerprint();
        Self {
            fields: fields.collect(),
            lookup: Lookup::new(&[file]),
            publisher: bus.publisher(service::AGENT_SENSORS).expect("a publisher"),
            subscriber: bus
                .subscriber(service::WHEEL_COMMANDS)
                .expect("a subscriber"),
            sensors,
            commands: WheelCommands::default(),
        }
    }

    fn publish(&mut self) {
        for (rows, field) in self
            .sensors
            .row
            .chunks_exact_mut(TEAM)
            .zip(&mut self.fields)
        {
            for (row, sensed) in rows.iter_mut().zip(field.sense()) {
                *row = sensed.into();
            }
        }
        self.sensors.stamp.captured_ns = now_ns();
        self.publisher.send(&self.sensors).expect("sent");
    }

    fn answer(&mut self, deadline_ns: u64) -> Option<u64> {
        loop {
            let came = self
                .subscriber
                .newest(&mut self.commands)
                .expect("readable");
            let now_ns = now_ns();
            if came && self.commands.frame == self.sensors.frame {
                return Some(now_ns);
            }
            if now_ns >= deadline_ns {
                return None;
            }
            std::hint::spin_loop();
        }
    }

    fn drive(&mut self) {
        let mut expected = [0; FIELDS * TEAM];
        self.lookup.answer(&self.sensors.row, &mut expected);
        assert_eq!(self.commands.output[..FIELDS * TEAM], expected);
        for (outputs, field) in expected.chunks_exact(TEAM).zip(&mut self.fields) {
            field.advance(&std::array::from_fn(|i| {
                Wheels::from_motor_bits(outputs[i])
            }));
        }
    }
}

fn main() {
    let frames = FRAMES[usize::from(!std::env::args().any(|word| word == "--bench"))];
    let bus = FreshBus::new("bench");
    let agents = start_agents(&bus);
    let member = Bus::open(&bus, "bench", Realtime::Yes).expect("a bus");
    let mut host = Host::open(&member);
    host.publish();
    while host.answer(now_ns() + PERIOD_NS).is_none() {
        assert!(
            now_ns() - host.sensors.stamp.captured_ns < START_NS,
            "ebts agents does not answer"
        );
        host.publisher.connect_readers().expect("reachable");
    }
    host.drive();

    let mut latency_ns = Histogram::<u64>::new_with_bounds(1, PERIOD_NS, 3).expect("valid bounds");
    let mut period_end_ns = now_ns();
    let (mut missed, mut withheld, mut late) = (0, 0, 0);
    let mut gap: Option<Gap> = None;
    for frame in 1..=WARM_UP + frames {
        period_end_ns += PERIOD_NS;
        host.sensors.frame = frame;
        host.sensors.stamp.sequence = frame;
        let waited_before_ns = waited_ns(&agents);
        host.publish();
        match host.answer(period_end_ns) {
            Some(answered_ns) => {
                host.drive();
                if let Some(gap) = gap.take() {
                    missed += gap.missed;
                    let waited_ns = waited_ns(&agents) - gap.waited_before_ns;
                    if 2 * waited_ns > answered_ns - gap.since_ns {
                        withheld += gap.missed;
                    }
                }
                if frame > WARM_UP {
                    latency_ns.saturating_record(answered_ns - host.sensors.stamp.captured_ns);
                }
            }
            None => {
                let gap = gap.get_or_insert(Gap {
                    since_ns: host.sensors.stamp.captured_ns,
                    waited_before_ns,
                    missed: 0,
                });
                gap.missed += u64::from(frame > WARM_UP);
            }
        }
        sleep_until(period_end_ns);
        let skipped = (now_ns() - period_end_ns) / PERIOD_NS;
        late += skipped;
        period_end_ns += skipped * PERIOD_NS;
    }
    missed += gap.map_or(0, |gap| gap.missed);
    let us = |quantile: f64| latency_ns.value_at_quantile(quantile) as f64 * 1e-3;
    println!(
        "{} robots at 1 kHz, {frames} frames: {missed} missed, {withheld} of them because other programs held the cores; \
         this process was late for {late} more periods\n\
         answer after p50 {:.1}  p99 {:.1}  p99.9 {:.1}  max {:.1} µs",
        FIELDS * TEAM,
        us(0.5),
        us(0.99),
        us(0.999),
        latency_ns.max() as f64 * 1e-3
    );
}

/// Sleeps until the deadline. The kernel throttles real-time processes that never sleep.
fn sleep_until(deadline_ns: u64) {
    let until = Timespec {
        tv_sec: (deadline_ns / 1_000_000_000).cast_signed(),
        tv_nsec: (deadline_ns % 1_000_000_000).cast_signed(),
    };
    while clock_nanosleep_absolute(ClockId::Monotonic, &until).is_err() {}
}

fn start_agents(bus: &FreshBus) -> Agents {
    let mut command = Command::new(env!("CARGO_BIN_EXE_ebts"));
    let arguments = ["agents", "--table", "r3-two-agents", "--bus", bus.as_str()];
    let started = command.args(arguments).stdout(Stdio::null()).spawn();
    Agents(started.expect("ebts starts"))
}
