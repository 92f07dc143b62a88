//! Bare loops: sleep until the next millisecond and read the clock. Optionally with the daemon's
//! measures against late wake-ups: spinning before the deadline and keeping the cores awake.

use std::fs::{File, OpenOptions};
use std::io::Write;
use std::time::Duration;

use anyhow::Context;
use atas_client::percentiles;
use atas_console::Interrupt;
use atas_process::scheduling;
use rustix::thread::clock_nanosleep_absolute;
use rustix::time::{ClockId, Timespec};
use shm_bus::now_ns;
use shm_schemas::Percentiles;

use super::tool::Notes;
use super::{Plan, machine};

/// Period of the loop, equal to that of the daemon, ns.
const PERIOD_NS: u64 = 1_000_000;

/// Spin time before a deadline, ns: the daemon's default maximum (`realtime.spin_us`).
const SPIN_NS: u64 = 50_000;
/// Device that disables deep idle states of the cores while 0 is written and the file is open.
const IDLE_LATENCY: &str = "/dev/cpu_dma_latency";

/// Measures of a bare loop against late wake-ups.
#[derive(Clone, Copy, Debug)]
pub(super) struct BareLoop {
    pub(super) spins: bool,
    pub(super) keeps_awake: bool,
}

/// Measures the wake-up latency of a bare loop on the plan's core. Returns `None` and adds a note
/// if the cores cannot be kept awake.
pub(super) fn measure(
    plan: &Plan<'_>,
    bare: BareLoop,
    notes: &mut Notes,
) -> anyhow::Result<Option<Percentiles>> {
    let awake = bare.keeps_awake.then(hold_awake).transpose();
    let Ok(_awake) = awake.map_err(|error| {
        notes.add(format!(
            "loops with cores kept awake were not measured: {IDLE_LATENCY}: {error}"
        ));
    }) else {
        return Ok(None);
    };
    let (core, window, interrupt) = (plan.core, plan.window, plan.interrupt.clone());
    let early_ns = if bare.spins { SPIN_NS } else { 0 };
    let looped = std::thread::spawn(move || run(core, window, early_ns, &interrupt)).join();
    let late_ns = looped.unwrap_or_else(|_| Err(anyhow::anyhow!("the bare loop panicked")))?;
    plan.interrupt.check("the bare loop was being measured")?;
    Ok(Some(percentiles::from_unsorted(late_ns)))
}

fn hold_awake() -> std::io::Result<File> {
    let mut file = OpenOptions::new().write(true).open(IDLE_LATENCY)?;
    file.write_all(&0_i32.to_ne_bytes())?;
    Ok(file)
}

fn run(
    core: usize,
    window: Duration,
    early_ns: u64,
    interrupt: &Interrupt,
) -> anyhow::Result<Vec<u64>> {
    machine::pin(core)?;
    // Without the permission, the daemon also runs without it, so results remain comparable.
    let _ = scheduling::enter_fifo(scheduling::TICK_PRIORITY);
    let ticks = u64::try_from(window.as_nanos())? / PERIOD_NS;
    let mut late_ns = Vec::with_capacity(usize::try_from(ticks)?);
    let mut deadline_ns = now_ns();
    while late_ns.len() < late_ns.capacity() && !interrupt.is_set() {
        deadline_ns += PERIOD_NS;
        sleep_until(deadline_ns - early_ns)?;
        let mut now = now_ns();
        while now < deadline_ns && !interrupt.is_set() {
            std::hint::spin_loop();
            now = now_ns();
        }
        let late = now.saturating_sub(deadline_ns);
        late_ns.push(late);
        // Missed deadlines are skipped, as in the daemon.
        deadline_ns += late / PERIOD_NS * PERIOD_NS;
    }
    Ok(late_ns)
}

fn sleep_until(deadline_ns: u64) -> anyhow::Result<()> {
    let deadline = Timespec {
        tv_sec: i64::try_from(deadline_ns / 1_000_000_000)?,
        tv_nsec: i64::try_from(deadline_ns % 1_000_000_000)?,
    };
    match clock_nanosleep_absolute(ClockId::Monotonic, &deadline) {
        // A signal ends the sleep early; the caller checks the flag.
        Ok(()) | Err(rustix::io::Errno::INTR) => Ok(()),
        Err(error) => Err(error).context("could not sleep"),
    }
}
