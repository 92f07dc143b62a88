//! The bare loop: sleep until the next millisecond, look at the clock, nothing else.

use std::time::Duration;

use anyhow::Context;
use atas_client::{fifo, percentiles};
use atas_console::Interrupt;
use rustix::thread::clock_nanosleep_absolute;
use rustix::time::{ClockId, Timespec};
use shm_bus::now_ns;
use shm_schemas::Percentiles;

use super::{Plan, machine};

/// Period of the loop: the daemon's.
const PERIOD_NS: u64 = 1_000_000;

/// How late a bare loop on the plan's core wakes up.
pub(super) fn measure(plan: &Plan<'_>) -> anyhow::Result<Percentiles> {
    let (core, window, interrupt) = (plan.core, plan.window, plan.interrupt.clone());
    let looped = std::thread::spawn(move || run(core, window, &interrupt)).join();
    let late_ns = looped.unwrap_or_else(|_| Err(anyhow::anyhow!("the bare loop panicked")))?;
    plan.interrupt.check("the bare loop was running")?;
    Ok(percentiles::of(late_ns))
}

fn run(core: usize, window: Duration, interrupt: &Interrupt) -> anyhow::Result<Vec<u64>> {
    machine::pin(core)?;
    // Without the right to it the daemon runs without it as well: the two stay comparable.
    let _ = fifo::enter(fifo::PRIORITY);
    let ticks = u64::try_from(window.as_nanos())? / PERIOD_NS;
    let mut late_ns = Vec::with_capacity(usize::try_from(ticks)?);
    let mut deadline_ns = now_ns();
    while late_ns.len() < late_ns.capacity() && !interrupt.is_set() {
        deadline_ns += PERIOD_NS;
        sleep_until(deadline_ns)?;
        let late = now_ns().saturating_sub(deadline_ns);
        late_ns.push(late);
        // What has passed is skipped, as in the daemon.
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
        // A signal ends the sleep early; the caller looks at the flag.
        Ok(()) | Err(rustix::io::Errno::INTR) => Ok(()),
        Err(error) => Err(error).context("could not sleep"),
    }
}
