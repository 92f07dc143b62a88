//! Real-time run: one tick per millisecond at absolute deadlines. Missed ticks are skipped and
//! counted; the phase is kept.

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use atas_process::scheduling;
use rustix::thread::clock_nanosleep_absolute;
use rustix::time::{ClockId, Timespec};
use shm_bus::now_ns;
use sim_backend::TICK_NS;

use crate::failure::Failure;
use crate::session::Session;

/// Publication period of the ground truth, ticks (50 Hz).
const TRUTH_TICKS: u64 = 20;

pub(crate) fn run(
    session: &mut Session,
    duration: Option<Duration>,
    stop: &AtomicBool,
) -> Result<(), Failure> {
    let begin_ns = now_ns();
    session.use_real_time(begin_ns);
    if let Err(refused) = scheduling::enter_fifo(scheduling::ROBOT_PRIORITY) {
        tracing::info!(%refused, "no real-time scheduling: ticks may be late on a busy machine");
    }
    session.publish()?;
    let mut deadline_ns = begin_ns + TICK_NS;
    while !stop.load(Ordering::Relaxed) && !session.is_over(duration) {
        if sleep_until(deadline_ns).is_err() {
            continue;
        }
        let missed = now_ns().saturating_sub(deadline_ns) / TICK_NS;
        session.count_missed(missed);
        deadline_ns += missed * TICK_NS;
        tick(session, deadline_ns)?;
        deadline_ns += TICK_NS;
    }
    Ok(())
}

/// Simulates the millisecond before the deadline, then publishes the sensors.
fn tick(session: &mut Session, deadline_ns: u64) -> Result<(), Failure> {
    session.world.skip_to(deadline_ns - TICK_NS);
    let command = session.newest_command()?;
    session.advance(command.as_ref())?;
    if session.world.tick().is_multiple_of(TRUTH_TICKS) {
        session.publish_truth()?;
    }
    session.publish().map(drop)
}

/// Returns an error if a signal interrupts the sleep.
pub(crate) fn sleep_until(deadline_ns: u64) -> rustix::io::Result<()> {
    let until = Timespec {
        tv_sec: (deadline_ns / 1_000_000_000).cast_signed(),
        tv_nsec: (deadline_ns % 1_000_000_000).cast_signed(),
    };
    clock_nanosleep_absolute(ClockId::Monotonic, &until)
}
