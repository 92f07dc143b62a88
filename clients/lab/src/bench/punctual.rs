//! Wake-up latency of the daemon and of reference loops, measured in turn on one core.

use std::path::Path;
use std::time::{Duration, Instant};

use anyhow::Context;
use atas_client::POLL;
use atas_client::percentiles;
use atas_process::stat::Stat;
use shm_schemas::capacity::STAGES;
use shm_schemas::{Percentiles, StatusFlags, TickReport};

use super::bare::{self, BareLoop};
use super::body::body_ns;
use super::load::Load;
use super::pair::Pair;
use super::response::{self, ResponseTimes};
use super::tool::Notes;
use super::{Plan, cyclictest};
use atas_processes::child::Child;

/// Longest time to phase lock (design choice: 5 µs per tick need 200 ticks for a whole period; the
/// filter lag needs longer).
const LOCK_TIMEOUT: Duration = Duration::from_secs(5);
const SETTLE: Duration = Duration::from_secs(1);
/// Free-running daemons per repeat, which share its window: each has a different constant phase to
/// the frames.
const FREE_RUNS: u32 = 3;
/// Half a tick of the measured daemon, which runs at 1 kHz, ns.
const HALF_TICK_NS: u64 = 500_000;
/// Most reports read at once: the queue length.
const AT_ONCE: usize = 256;

/// One repeat on an otherwise idle machine.
pub(super) struct Repeat {
    pub(super) references: References,
    pub(super) locked: Measured,
    pub(super) not_kept_awake: Measured,
    pub(super) free: Vec<Measured>,
    pub(super) answer: ResponseTimes,
}

/// References for the daemon's wake-up latency.
#[derive(Clone, Copy)]
pub(super) struct References {
    pub(super) cyclictest: Option<Percentiles>,
    /// Without spinning, cores not kept awake.
    pub(super) bare: Option<Percentiles>,
    /// Cores kept awake, as by cyclictest and the daemon.
    pub(super) bare_awake: Option<Percentiles>,
    /// Cores kept awake, spinning before deadlines, as in the daemon.
    pub(super) bare_spinning: Option<Percentiles>,
}

impl References {
    fn measure(plan: &Plan<'_>, notes: &mut Notes) -> anyhow::Result<Self> {
        let mut bare = |spins, keeps_awake| {
            let bare = BareLoop { spins, keeps_awake };
            bare::measure(plan, bare, notes)
        };
        Ok(Self {
            bare: bare(false, false)?,
            bare_awake: bare(false, true)?,
            bare_spinning: bare(true, true)?,
            cyclictest: cyclictest::measure(plan, notes)?,
        })
    }
}

impl Repeat {
    pub(super) fn measure(plan: &Plan<'_>, notes: &mut Notes) -> anyhow::Result<Self> {
        Ok(Self {
            references: References::measure(plan, notes)?,
            locked: daemon(plan, plan.window, Variant::DEFAULT, notes)?,
            not_kept_awake: daemon(plan, plan.window, Variant::NOT_KEPT_AWAKE, notes)?,
            free: free(plan, notes)?,
            answer: response::measure(plan)?,
        })
    }
}

/// One repeat with other load on the core.
pub(super) struct Loaded {
    pub(super) references: References,
    pub(super) locked: Measured,
}

impl Loaded {
    /// Returns `None` if the load program is not available.
    pub(super) fn measure(plan: &Plan<'_>, notes: &mut Notes) -> anyhow::Result<Option<Self>> {
        let Some(_load) = Load::start(plan, notes)? else {
            return Ok(None);
        };
        Ok(Some(Self {
            references: References::measure(plan, notes)?,
            locked: daemon(plan, plan.window, Variant::DEFAULT, notes)?,
        }))
    }
}

/// Measurements from the daemon's reports and from the kernel's accounting.
pub(super) struct Measured {
    pub(super) wake: Percentiles,
    pub(super) body: Percentiles,
    pub(super) stages: [Percentiles; STAGES],
    pub(super) sensor_to_command: Percentiles,
    pub(super) frame_age_ns: Vec<u64>,
    /// CPU time of the tick thread, including the spin, percent of one core.
    pub(super) tick_cpu_percent: f64,
    /// CPU time of the whole process, percent of one core.
    pub(super) cpu_percent: f64,
    pub(super) resident_mib: f64,
    pub(super) page_faults: u64,
    pub(super) missed_ticks: u64,
    pub(super) first_tick_ns: Option<u64>,
    /// True if the kernel granted all real-time settings.
    pub(super) is_realtime: bool,
}

/// Returns the share of ticks, over all runs, whose frame was younger than half a tick. Without
/// phase lock each run has a constant phase, and the share is about a half over many runs.
pub(super) fn fresh_share<'a>(runs: impl Iterator<Item = &'a Measured>) -> f64 {
    let (mut fresh, mut ticks) = (0_u32, 0_u32);
    for age_ns in runs.flat_map(|run| &run.frame_age_ns) {
        ticks += 1;
        fresh += u32::from(*age_ns < HALF_TICK_NS);
    }
    f64::from(fresh) / f64::from(ticks.max(1))
}

#[derive(Clone, Copy)]
struct Variant {
    phase_lock: bool,
    keep_awake: bool,
}

impl Variant {
    const DEFAULT: Self = Self {
        phase_lock: true,
        keep_awake: true,
    };
    const NOT_KEPT_AWAKE: Self = Self {
        keep_awake: false,
        ..Self::DEFAULT
    };
    const FREE: Self = Self {
        phase_lock: false,
        ..Self::DEFAULT
    };
}

fn free(plan: &Plan<'_>, notes: &mut Notes) -> anyhow::Result<Vec<Measured>> {
    let window = plan.window / FREE_RUNS;
    (0..FREE_RUNS)
        .map(|_| daemon(plan, window, Variant::FREE, notes))
        .collect()
}

fn daemon(
    plan: &Plan<'_>,
    window: Duration,
    Variant {
        phase_lock,
        keep_awake,
    }: Variant,
    notes: &mut Notes,
) -> anyhow::Result<Measured> {
    let cpu = format!("realtime.cpu={}", plan.core);
    let lock = format!("realtime.phase_lock={phase_lock}");
    let awake = format!("realtime.keep_awake={keep_awake}");
    let flags = ["--set", &cpu, "--set", &lock, "--set", &awake];
    let start =
        |site: &super::site::Site, control: &[&str]| Child::start("atasd", control, site.folder());
    let mut pair = Pair::start(&flags, start)?;
    pair.wait_until_ready(plan.interrupt)?;
    let first_tick_ns = pair.first_tick_ns()?;
    let is_locked = |status: &shm_schemas::Status| status.flags & StatusFlags::PHASE_LOCKED != 0;
    if phase_lock && !pair.wait_until(LOCK_TIMEOUT, plan.interrupt, is_locked)? {
        notes.add(format!(
            "the phase lock took longer than {LOCK_TIMEOUT:?}; frame_age_us.locked is not valid"
        ));
    }
    let mut ticks = Ticks::default();
    let settle = if phase_lock { SETTLE } else { SETTLE / 4 };
    let _settled = collect_reports(&mut pair, settle, plan, &mut Ticks::default())?;
    let used = collect_reports(&mut pair, window, plan, &mut ticks)?;
    Ok(Measured {
        wake: percentiles::from_unsorted(ticks.wake),
        body: percentiles::from_unsorted(ticks.body),
        stages: ticks.stages.map(percentiles::from_unsorted),
        sensor_to_command: percentiles::from_unsorted(ticks.sensor_to_command),
        frame_age_ns: ticks.frame_age,
        tick_cpu_percent: used.tick_cpu_percent,
        cpu_percent: used.cpu_percent,
        page_faults: used.page_faults,
        missed_ticks: used.missed_ticks,
        resident_mib: resident_mib(&pair.process())?,
        first_tick_ns,
        is_realtime: pair.status.flags & StatusFlags::DEGRADED == 0,
    })
}

#[derive(Default)]
pub(super) struct Ticks {
    pub(super) wake: Vec<u64>,
    frame_age: Vec<u64>,
    pub(super) body: Vec<u64>,
    stages: [Vec<u64>; STAGES],
    sensor_to_command: Vec<u64>,
}

impl Ticks {
    fn add(&mut self, report: &TickReport) {
        self.wake.push(report.wake_late_ns.into());
        self.body.push(body_ns(report));
        let ages = report.hands.iter().map(|hand| hand.frame_age_ns);
        self.frame_age.push(ages.min().unwrap_or(u64::MAX));
        self.sensor_to_command
            .push(report.sensor_to_command_ns.into());
        for (stage, ns) in self.stages.iter_mut().zip(report.stage_ns) {
            stage.push(ns.into());
        }
    }
}

pub(super) struct Used {
    tick_cpu_percent: f64,
    cpu_percent: f64,
    page_faults: u64,
    pub(super) missed_ticks: u64,
}

pub(super) fn collect_reports(
    pair: &mut Pair,
    window: Duration,
    plan: &Plan<'_>,
    ticks: &mut Ticks,
) -> anyhow::Result<Used> {
    let (process, thread) = (pair.process(), pair.tick_thread()?);
    pair.refresh()?;
    let missed = pair.status.missed_ticks;
    let (tick_cpu, cpu) = (thread_cpu_s(&thread)?, process_cpu_s(&process)?);
    let (faults, begin) = (page_faults(&thread)?, Instant::now());
    while begin.elapsed() < window {
        plan.interrupt.check("the daemon was being measured")?;
        pair.reports.drain(AT_ONCE, |report| ticks.add(report))?;
        std::thread::sleep(POLL);
    }
    pair.check()?;
    pair.refresh()?;
    let percent = |used_s: f64| 100.0 * used_s / begin.elapsed().as_secs_f64();
    Ok(Used {
        tick_cpu_percent: percent(thread_cpu_s(&thread)? - tick_cpu),
        cpu_percent: percent(process_cpu_s(&process)? - cpu),
        page_faults: page_faults(&thread)? - faults,
        missed_ticks: pair.status.missed_ticks - missed,
    })
}

fn read(path: &Path) -> anyhow::Result<String> {
    std::fs::read_to_string(path).with_context(|| format!("could not read {}", path.display()))
}

/// Returns the CPU time of all living threads of a process, s.
fn process_cpu_s(process: &Path) -> anyhow::Result<f64> {
    let folder = process.join("task");
    let tasks = std::fs::read_dir(&folder);
    let tasks = tasks.with_context(|| format!("could not read {}", folder.display()))?;
    tasks.flatten().map(|task| thread_cpu_s(&task.path())).sum()
}

fn thread_cpu_s(thread: &Path) -> anyhow::Result<f64> {
    let text = read(&thread.join("schedstat"))?;
    let first = text.split_whitespace().next();
    let ns = first.and_then(|word| word.parse::<u64>().ok());
    let ns = ns.with_context(|| format!("could not parse a time from {text:?}"))?;
    Ok(ns as f64 * 1e-9)
}

fn page_faults(thread: &Path) -> anyhow::Result<u64> {
    let stat = Stat::read(thread).context("could not count the page faults of the tick thread")?;
    Ok(stat.page_faults)
}

fn resident_mib(process: &Path) -> anyhow::Result<f64> {
    let text = read(&process.join("status"))?;
    let line = text.lines().find_map(|line| line.strip_prefix("VmRSS:"));
    let kib = line.and_then(|rest| rest.split_whitespace().next()?.parse::<f64>().ok());
    Ok(kib.context("could not read VmRSS")? / 1024.0)
}
