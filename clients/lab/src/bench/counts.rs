//! Cost of a tick in counts that do not depend on machine load: allocations, instructions, system
//! calls.

use std::path::Path;
use std::time::Duration;

use anyhow::Context;
use serde::Deserialize;
use serde_json::Value;

use super::Plan;
use super::pair::Pair;
use super::site::Site;
use super::tool::{self, Notes};
use atas_processes::child::{Child, sibling_program};

/// Program that runs the production tick and a simulated world in one thread.
const HELPER: &str = "atas-bench";
const HELPER_HINT: &str = "build everything with `cargo build --workspace`; without it tick_us, allocs_per_tick and \
    instructions_per_tick are null";
const TICKS: &str = "8000";
/// Number of ticks under callgrind, which is fifty times slower.
const TICKS_COUNTED: u32 = 3000;
/// Longest run time, valid for callgrind on a loaded machine.
const TIMEOUT: Duration = Duration::from_secs(120);
/// Option that restricts instruction counting to the tick function.
const TICK_FUNCTION: &str = "--toggle-collect=*production_tick*";
/// Settings slow enough for a traced process on a loaded machine.
const TRACED: [&str; 10] = [
    "--set",
    "realtime.rate_hz=200",
    "--set",
    "intake.hold_age_s=0.3",
    "--set",
    "intake.reject_age_s=5.0",
    "--set",
    "safety.stall_s=1.0",
    "--set",
    "safety.valid_s=0.02",
];
/// Number of initial sleeps without counting: the tick thread connects and touches its memory.
const WARM_UP: usize = 100;
const TRACE: Duration = Duration::from_secs(4);

pub(super) struct Counts {
    pub(super) ticks: Option<Ticks>,
    pub(super) instructions_per_tick: Option<f64>,
    pub(super) syscalls_per_tick: Option<f64>,
}

#[derive(Deserialize)]
pub(super) struct Ticks {
    pub(super) body_us: Value,
    pub(super) stages_us: Value,
    pub(super) recording_ratio: f64,
    pub(super) recording_tick_ratio: f64,
    pub(super) recording_us: f64,
    pub(super) allocations_per_tick: f64,
    pub(super) allocations_max: u64,
}

impl Counts {
    pub(super) fn measure(plan: &Plan<'_>, notes: &mut Notes) -> anyhow::Result<Self> {
        let Ok(helper) = sibling_program(HELPER) else {
            notes.add(format!("{HELPER} was not found; {HELPER_HINT}"));
            return Ok(Self {
                ticks: None,
                instructions_per_tick: None,
                syscalls_per_tick: syscalls(plan, notes)?,
            });
        };
        Ok(Self {
            ticks: Some(ticks(&helper, plan)?),
            instructions_per_tick: instructions(&helper, plan, notes)?,
            syscalls_per_tick: syscalls(plan, notes)?,
        })
    }
}

fn ticks(helper: &Path, plan: &Plan<'_>) -> anyhow::Result<Ticks> {
    let site = Site::new()?;
    let repeats = plan.repeats.to_string();
    let arguments = ["figures", TICKS, &repeats];
    let mut child = Child::start_program(helper, HELPER, &arguments, site.folder())?;
    let status = tool::wait(&mut child, TIMEOUT * plan.repeats, plan.interrupt)?;
    let line = child.results().pop().unwrap_or_default();
    anyhow::ensure!(status.success(), "{HELPER} failed: {}", child.tail());
    serde_json::from_str(&line).with_context(|| format!("could not parse the output of {HELPER}"))
}

/// Counts instructions of the tick with callgrind (Debian package valgrind).
fn instructions(helper: &Path, plan: &Plan<'_>, notes: &mut Notes) -> anyhow::Result<Option<f64>> {
    let site = Site::new()?;
    let out = site.folder().join("callgrind");
    let out_flag = format!("--callgrind-out-file={}", out.display());
    let (path, ticks) = (helper.display().to_string(), TICKS_COUNTED.to_string());
    let arguments = [
        "--tool=callgrind",
        TICK_FUNCTION,
        &out_flag,
        &path,
        "run",
        &ticks,
    ];
    let cure = "apt-get install valgrind; without it instructions_per_tick is null";
    let program = Path::new("valgrind");
    let started = tool::start(program, "valgrind", cure, &arguments, site.folder(), notes)?;
    let Some(mut child) = started else {
        return Ok(None);
    };
    let status = tool::wait(&mut child, TIMEOUT, plan.interrupt)?;
    let counted = std::fs::read_to_string(&out).unwrap_or_default();
    let total = counted.lines().find_map(|line| {
        let rest = line
            .strip_prefix("summary:")
            .or(line.strip_prefix("totals:"));
        rest?.trim().parse::<f64>().ok()
    });
    if !status.success() || total.is_none_or(|total| total == 0.0) {
        notes.add(format!(
            "callgrind failed: {}; instructions_per_tick is null",
            child.tail().trim()
        ));
        return Ok(None);
    }
    Ok(total.map(|total| total / f64::from(TICKS_COUNTED)))
}

/// Counts system calls of the daemon's tick thread, including its sleep (Debian package strace).
fn syscalls(plan: &Plan<'_>, notes: &mut Notes) -> anyhow::Result<Option<f64>> {
    if !can_trace(plan, notes)? {
        return Ok(None);
    }
    let atasd = sibling_program("atasd")?.display().to_string();
    let start = |site: &Site, control: &[&str]| {
        let out = site.folder().join("trace").display().to_string();
        // With -D the daemon remains a child of this process; strace is its grandchild and ends
        // with it.
        let strace = ["-D", "-f", "-qq", "-o", &out, &atasd];
        let arguments = [&strace, control].concat();
        Child::start_program(Path::new("strace"), "strace", &arguments, site.folder())
    };
    let mut pair = Pair::start(&TRACED, start)?;
    pair.wait_until_ready(plan.interrupt)?;
    pair.wait_until(TRACE, plan.interrupt, |_| false)?;
    let thread = pair.tick_thread()?;
    let thread = thread
        .file_name()
        .unwrap_or_default()
        .to_string_lossy()
        .into_owned();
    let text = std::fs::read_to_string(pair.site().folder().join("trace"));
    let text = text.context("could not read the output of strace")?;
    let per_tick = calls_per_sleep(&text, &thread);
    if per_tick.is_none() {
        notes.add("strace recorded too few ticks; syscalls_per_tick is null".to_owned());
    }
    Ok(per_tick)
}

fn can_trace(plan: &Plan<'_>, notes: &mut Notes) -> anyhow::Result<bool> {
    let site = Site::new()?;
    let cure = "apt-get install strace; without it syscalls_per_tick is null";
    let arguments = ["-D", "-f", "-qq", "-o", "/dev/null", "true"];
    let program = Path::new("strace");
    let tried = tool::start(program, "strace", cure, &arguments, site.folder(), notes)?;
    let Some(mut tried) = tried else {
        return Ok(false);
    };
    let status = tool::wait(&mut tried, TIMEOUT, plan.interrupt)?;
    if !status.success() {
        notes.add("strace is not permitted to trace here; syscalls_per_tick is null".to_owned());
    }
    Ok(status.success())
}

/// Returns the system calls of a thread per sleep, after its first sleeps.
fn calls_per_sleep(trace: &str, thread: &str) -> Option<f64> {
    let calls: Vec<&str> = trace
        .lines()
        .filter_map(|line| line.strip_prefix(thread)?.trim_start().split_once('('))
        .map(|(name, _)| name)
        .filter(|name| !name.contains("resumed"))
        .collect();
    let is_sleep = |call: &&&str| **call == "clock_nanosleep";
    let sleeps = || calls.iter().enumerate().filter(|(_, call)| is_sleep(call));
    let (begin, _) = sleeps().nth(WARM_UP)?;
    let (end, _) = sleeps().next_back()?;
    let count = calls[begin..end].iter().filter(is_sleep).count();
    (count > WARM_UP).then(|| (end - begin) as f64 / count as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn system_calls_between_sleeps_are_counted() {
        let check = |other: &str, expected| {
            let mut trace = "8 openat(AT_FDCWD) = 3\n".to_owned();
            for tick in 0..300 {
                trace += "7 clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME) = 0\n9 futex(0) = 0\n";
                if tick % 2 == 1 {
                    trace += other;
                }
            }
            let per_tick = calls_per_sleep(&trace, "7").map(|n| (n * 10.0).round() / 10.0);
            assert_eq!(per_tick, expected, "{other}");
        };
        check("", Some(1.0));
        check("7 futex(0) = 0\n", Some(1.5));
        check("7 <... clock_nanosleep resumed>) = 0\n", Some(1.0));
        assert_eq!(calls_per_sleep("7 clock_nanosleep(0) = 0\n", "7"), None);
    }
}
