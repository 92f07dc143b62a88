//! Counts and times of the production tick, for `atas bench latency` and the benchmarks.
//!
//! ```text
//! atas-bench figures TICKS REPEATS   times and allocations with and without recording; prints JSON
//! atas-bench run TICKS               ticks for an external tracer; prints JSON of internal counts
//! ```
//!
//! `run` calls `getppid` once before and once after the steady ticks. System calls between the two
//! marks belong to the ticks.
#![expect(
    clippy::print_stdout,
    reason = "figures are the product of this program"
)]

use std::path::Path;
use std::process::ExitCode;

use allocation_counter::measure;
use atas_process::stat::Stat;
use rustix::mm::MlockAllFlags;
use serde_json::{Value, json};
use shm_schemas::TickReport;
use shm_schemas::capacity::STAGES;
use system_tests::figures::{median, microseconds};
use system_tests::loopback::Loopback;

/// Ticks before measurement: connections and the goal start.
const WARM_UP: u64 = 500;
/// Ticks per block; recording and non-recording blocks alternate. Long enough for each to fill the
/// caches.
const BLOCK: u64 = 250;
const USAGE: &str = "could not parse the arguments: needs `figures TICKS REPEATS` or `run TICKS`";
/// Index of the recording stage, which runs after the body.
const RECORDING: usize = STAGES - 1;

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let words: Vec<&str> = arguments.iter().map(String::as_str).collect();
    let number = |word: &str| word.parse::<u64>().ok().filter(|count| *count > 0);
    let figures = match words[..] {
        ["figures", ticks, repeats] => number(ticks)
            .zip(number(repeats))
            .map(|(ticks, repeats)| figures(ticks, repeats)),
        ["run", ticks] => number(ticks).map(run),
        _ => None,
    };
    println!(
        "{}",
        figures.clone().unwrap_or_else(|| json!({"error": USAGE}))
    );
    if figures.is_some() {
        ExitCode::SUCCESS
    } else {
        ExitCode::from(2)
    }
}

/// Measured costs of the ticks of one loopback.
#[derive(Default)]
struct Costs {
    body_ns: Vec<u64>,
    stages_ns: [Vec<u64>; STAGES],
    allocations: u64,
    allocations_max: u64,
    ticks: u64,
}

impl Costs {
    /// Runs ticks and adds their costs.
    fn add(&mut self, loopback: &mut Loopback, ticks: u64) {
        for _ in 0..ticks {
            loopback.sense();
            let allocations = measure(|| loopback.tick()).count_total;
            let record = loopback.act();
            self.allocations += allocations;
            self.allocations_max = self.allocations_max.max(allocations);
            self.body_ns.push(record.body_ns.into());
            for (stage, ns) in self.stages_ns.iter_mut().zip(record.report.stage_ns) {
                stage.push(ns.into());
            }
            self.ticks += 1;
        }
    }

    fn body_us(&self) -> [f64; 4] {
        microseconds(self.body_ns.clone())
    }

    /// Returns the duration of body and recording of each tick.
    fn tick_us(&self) -> [f64; 4] {
        let recording_ns = &self.stages_ns[RECORDING];
        let both = self.body_ns.iter().zip(recording_ns).map(|(a, b)| a + b);
        microseconds(both.collect())
    }
}

fn figures(ticks: u64, repeats: u64) -> Value {
    let (mut plain, mut recording) = (Vec::new(), Vec::new());
    for _ in 0..repeats {
        let (mut one, mut other) = (Loopback::new(false), Loopback::new(true));
        let (mut costs, mut costs_recording) = (Costs::default(), Costs::default());
        Costs::default().add(&mut one, WARM_UP);
        Costs::default().add(&mut other, WARM_UP);
        for _ in 0..ticks.div_ceil(BLOCK) {
            costs.add(&mut one, BLOCK);
            costs_recording.add(&mut other, BLOCK);
        }
        plain.push(costs);
        recording.push(costs_recording);
    }
    let ratio = |p50: fn(&Costs) -> f64| {
        let pairs = plain.iter().zip(&recording);
        median(
            pairs
                .map(|(plain, recording)| p50(recording) / p50(plain))
                .collect(),
        )
    };
    let body_ratio = ratio(|costs| costs.body_us()[0]);
    let tick_ratio = ratio(|costs| costs.tick_us()[0]);
    let all = || plain.iter().chain(&recording);
    let ticks = all().map(|costs| costs.ticks).sum::<u64>() as f64;
    let after_body = recording
        .iter()
        .map(|costs| microseconds(costs.stages_ns[RECORDING].clone())[0]);
    json!({
        "body_us": medians(plain.iter().map(Costs::body_us)),
        "stages_us": stages(&plain),
        "recording_ratio": body_ratio,
        "recording_tick_ratio": tick_ratio,
        "recording_us": median(after_body.collect()),
        "allocations_per_tick": all().map(|costs| costs.allocations).sum::<u64>() as f64 / ticks,
        "allocations_max": all().map(|costs| costs.allocations_max).max(),
    })
}

fn stages(costs: &[Costs]) -> Value {
    let of = |stage: usize| {
        let each = costs.iter().map(|costs| costs.stages_ns[stage].clone());
        medians(each.map(microseconds))
    };
    let named = TickReport::STAGE_NAMES[..RECORDING].iter().enumerate();
    Value::Object(
        named
            .map(|(stage, name)| ((*name).to_owned(), of(stage)))
            .collect(),
    )
}

/// Returns the medians over the repeats.
fn medians(repeats: impl Iterator<Item = [f64; 4]>) -> Value {
    let repeats: Vec<[f64; 4]> = repeats.collect();
    let of = |at: usize| median(repeats.iter().map(|figures| figures[at]).collect());
    json!({"p50": of(0), "p99": of(1), "p999": of(2), "max": of(3)})
}

fn run(ticks: u64) -> Value {
    let mut loopback = Loopback::new(false);
    let mut costs = Costs::default();
    costs.add(&mut loopback, WARM_UP.min(ticks / 2));
    // As in the daemon. If locking fails, `page_faults` reveals it.
    let locked = rustix::mm::mlockall(MlockAllFlags::CURRENT | MlockAllFlags::FUTURE).is_ok();
    let (mut allocations, mut most) = (0, 0);
    let faults = page_faults();
    let steady = ticks - costs.ticks;
    let _begin = rustix::process::getppid();
    for _ in 0..steady {
        loopback.sense();
        let made = measure(|| loopback.tick()).count_total;
        (allocations, most) = (allocations + made, made.max(most));
        loopback.act();
    }
    let _end = rustix::process::getppid();
    json!({
        "ticks": steady,
        "allocations": allocations,
        "allocations_max": most,
        "page_faults": page_faults() - faults,
        "memory_locked": locked,
    })
}

/// Returns the page faults of this thread so far.
fn page_faults() -> u64 {
    let thread = Stat::read(Path::new("/proc/thread-self"));
    thread.expect("this thread exists").page_faults
}
