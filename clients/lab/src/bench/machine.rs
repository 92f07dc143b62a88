//! Description of this machine, and choice of cores.

use anyhow::Context;
use rustix::thread::{CpuSet, sched_getaffinity, sched_setaffinity};

/// Returns the last core available to this process; it is the least likely to serve interrupts.
pub(super) fn last_core() -> anyhow::Result<usize> {
    let allowed = sched_getaffinity(None).context("could not read the allowed cores")?;
    let last = (0..CpuSet::MAX_CPU)
        .rev()
        .find(|core| allowed.is_set(*core));
    last.context("could not find a core that this process may use")
}

/// Returns another core available to this process, or the same one if there is no other.
pub(super) fn other_core(core: usize) -> anyhow::Result<usize> {
    let allowed = sched_getaffinity(None).context("could not ask for the allowed cores")?;
    let mut others = (0..CpuSet::MAX_CPU).filter(|other| *other != core && allowed.is_set(*other));
    Ok(others.next().unwrap_or(core))
}

pub(super) fn pin(core: usize) -> anyhow::Result<()> {
    let mut cores = CpuSet::new();
    cores.set(core);
    sched_setaffinity(None, &cores)
        .with_context(|| format!("could not pin a thread to core {core}"))
}

pub(super) fn name() -> String {
    let text = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let model = text
        .lines()
        .find_map(|line| line.strip_prefix("model name"));
    let model = model.map_or("unknown", |rest| rest.trim_start_matches([' ', '\t', ':']));
    let cores = std::thread::available_parallelism().map_or(0, usize::from);
    format!("{model}, {cores} cores")
}

pub(super) fn kernel() -> String {
    let uname = rustix::system::uname();
    format!(
        "{} {}",
        uname.release().to_string_lossy(),
        uname.version().to_string_lossy()
    )
}
