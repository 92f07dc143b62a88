//! Runner: executes a target on its seeds and on mutations of them, on several threads.
//!
//! A failure is a panic, an endless loop, or more memory than the target's limit. Seed and number
//! of an execution determine its input. The runner measures the processor time of every input.

use std::cell::Cell;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

use rustix::time::{ClockId, clock_gettime};

use crate::mutate::mutated;
use crate::random::Random;
use crate::target::Target;

/// Processor time of one input that the command reports as a failure, ns. The ordinary tests do not
/// check it, because it depends on the machine.
pub const SLOW_NS: u64 = 100_000_000;
/// Wall-clock time after which an input counts as an endless loop.
const HANG: Duration = Duration::from_secs(30);
/// Executions per report of a worker.
const BATCH: u64 = 64;
/// Most failures kept.
const FAILURES_MAX: usize = 20;

/// Extent of a run.
#[derive(Clone, Copy, Debug)]
pub struct Extent {
    /// Number of executions after the seeds.
    pub executions: u64,
    /// Most time; `None` for no limit.
    pub time: Option<Duration>,
    /// Seed of the mutations.
    pub seed: u64,
    /// Threads.
    pub threads: usize,
}

/// Failed execution.
#[derive(Clone, Debug)]
pub struct Failure {
    /// Number of the execution; seeds are first.
    pub execution: u64,
    /// Cause.
    pub cause: String,
    /// Input.
    pub input: Vec<u8>,
}

/// Result of a run.
#[derive(Clone, Debug, Default)]
pub struct Report {
    /// Executions.
    pub executions: u64,
    /// Duration.
    pub elapsed: Duration,
    /// Processor time of the slowest input, ns, and the input.
    pub slowest: (u64, Vec<u8>),
    /// Largest memory of one input, bytes.
    pub memory_bytes: u64,
    /// Failures, at most twenty.
    pub failures: Vec<Failure>,
    /// Number of failures.
    pub failed: u64,
}

/// Input of an execution: the seeds in order, then mutations.
#[must_use]
pub fn input_of(target: &Target, seeds: &[Vec<u8>], seed: u64, execution: u64) -> Vec<u8> {
    let of_seed = usize::try_from(execution)
        .ok()
        .and_then(|index| seeds.get(index));
    match of_seed {
        Some(input) => input.clone(),
        None => mutated(seeds, target.length_max, &mut Random::new(seed, execution)),
    }
}

/// Runs a target.
///
/// # Panics
/// An input does not end. The message contains its execution.
#[must_use]
pub fn run(target: &Target, extent: Extent) -> Report {
    let seeds = (target.seeds)();
    let begun = Instant::now();
    let end = seeds.len() as u64 + extent.executions;
    let next = AtomicU64::new(0);
    let report = Mutex::new(Report::default());
    let running: Vec<Mutex<Option<(u64, Instant)>>> = (0..extent.threads.max(1))
        .map(|_| Mutex::new(None))
        .collect();
    let open = AtomicU64::new(running.len() as u64);
    std::thread::scope(|scope| {
        for current in &running {
            let (next, report, seeds, open) = (&next, &report, &seeds, &open);
            scope.spawn(move || {
                QUIET.set(true);
                loop {
                    let first = next.fetch_add(BATCH, Ordering::Relaxed);
                    let is_over = extent.time.is_some_and(|time| begun.elapsed() > time);
                    if first >= end || is_over {
                        break;
                    }
                    let mut part = Report::default();
                    for execution in first..end.min(first + BATCH) {
                        if let Ok(mut current) = current.lock() {
                            *current = Some((execution, Instant::now()));
                        }
                        let input = input_of(target, seeds, extent.seed, execution);
                        execute(target, execution, input, &mut part);
                    }
                    if let Ok(mut report) = report.lock() {
                        merge(&mut report, part);
                    }
                }
                if let Ok(mut current) = current.lock() {
                    *current = None;
                }
                open.fetch_sub(1, Ordering::Release);
            });
        }
        while open.load(Ordering::Acquire) > 0 {
            std::thread::sleep(Duration::from_millis(2));
            for current in &running {
                let Ok(Some((execution, since))) = current.lock().map(|current| *current) else {
                    continue;
                };
                if since.elapsed() > HANG {
                    stop_hanging(target, extent.seed, execution);
                }
            }
        }
    });
    let mut report = report.into_inner().unwrap_or_default();
    report.elapsed = begun.elapsed();
    report.failures.sort_by_key(|failure| failure.execution);
    report
}

/// Ends the process: a thread in an endless loop cannot be ended.
#[expect(clippy::print_stderr, reason = "the process ends here")]
fn stop_hanging(target: &Target, seed: u64, execution: u64) -> ! {
    eprintln!(
        "{}: execution {execution} of seed {seed} does not end; repeat it with `atas-fuzz {} \
         --seed {seed} --execution {execution}`",
        target.name, target.name
    );
    std::process::exit(70)
}

/// Executes one input and adds its result.
fn execute(target: &Target, execution: u64, input: Vec<u8>, report: &mut Report) {
    let before_ns = processor_ns();
    let mut caught = Ok(());
    let memory = allocation_counter::measure(|| {
        caught = catch_unwind(AssertUnwindSafe(|| (target.run)(&input)));
    });
    let took_ns = processor_ns().saturating_sub(before_ns);
    report.executions += 1;
    report.memory_bytes = report.memory_bytes.max(memory.bytes_max);
    let cause = match caught {
        Err(panic) => {
            let text = panic.downcast_ref::<String>().map(String::as_str);
            let text = text.or_else(|| panic.downcast_ref::<&str>().copied());
            let place = PLACE.take();
            Some(format!("panic at {place}: {}", text.unwrap_or("no text")))
        }
        Ok(()) if memory.bytes_max > target.memory_max => {
            Some(format!("allocated {} bytes", memory.bytes_max))
        }
        Ok(()) => None,
    };
    if took_ns > report.slowest.0 {
        report.slowest = (took_ns, input.clone());
    }
    if let Some(cause) = cause {
        report.failed += 1;
        if report.failures.len() < FAILURES_MAX {
            report.failures.push(Failure {
                execution,
                cause,
                input,
            });
        }
    }
}

fn merge(report: &mut Report, part: Report) {
    report.executions += part.executions;
    report.failed += part.failed;
    report.memory_bytes = report.memory_bytes.max(part.memory_bytes);
    if part.slowest.0 > report.slowest.0 {
        report.slowest = part.slowest;
    }
    report.failures.extend(part.failures);
    report.failures.truncate(FAILURES_MAX);
}

fn processor_ns() -> u64 {
    let now = clock_gettime(ClockId::ThreadCPUTime);
    now.tv_sec.unsigned_abs() * 1_000_000_000 + now.tv_nsec.unsigned_abs()
}

thread_local! {
    /// True on threads whose panics are results.
    static QUIET: Cell<bool> = const { Cell::new(false) };
    /// Place of the last panic of this thread.
    static PLACE: Cell<String> = const { Cell::new(String::new()) };
}

/// Keeps the place of a panic instead of printing it. Call once per process.
pub fn collect_panics() {
    let usual = std::panic::take_hook();
    std::panic::set_hook(Box::new(move |panic| {
        if QUIET.get() {
            PLACE.set(
                panic
                    .location()
                    .map(ToString::to_string)
                    .unwrap_or_default(),
            );
        } else {
            usual(panic);
        }
    }));
}

#[cfg(test)]
mod tests {
    use std::hint::black_box;

    use super::*;

    fn extent(executions: u64) -> Extent {
        Extent {
            executions,
            time: None,
            seed: 1,
            threads: 2,
        }
    }

    fn no_seeds() -> Vec<Vec<u8>> {
        vec![b"fine".to_vec()]
    }

    #[test]
    fn panics_and_their_inputs_are_reported() {
        let run_target = |bytes: &[u8]| assert!(bytes.len() < 100, "too long");
        let report = run(&Target::new("x", run_target, no_seeds), extent(3_000));
        assert_eq!(report.executions, 3_001);
        assert!(report.failed > 0 && !report.failures.is_empty());
        for failure in &report.failures {
            assert!(failure.cause.contains("too long"), "{failure:?}");
            let target = Target::new("x", run_target, no_seeds);
            assert_eq!(
                input_of(&target, &no_seeds(), 1, failure.execution),
                failure.input
            );
        }
    }

    #[test]
    fn memory_beyond_the_limit_is_a_failure() {
        let hungry = |bytes: &[u8]| drop(black_box(vec![1_u8; bytes.len() << 10]));
        let target = Target::new("x", hungry, no_seeds);
        assert_eq!(run(&target, extent(500)).failed, 0);
        let report = run(&target.memory(4 << 10), extent(500));
        assert!(
            report
                .failures
                .iter()
                .any(|failure| failure.cause.contains("allocated"))
        );
    }
}
