//! When the next tick begins.
//!
//! * [`FreePacer`] follows the machine's clock: absolute deadlines, sleep until shortly before, then spin. A late tick
//!   is never caught up: whole periods that have passed are skipped and counted, the phase is kept. With a [`PhaseLock`]
//!   the deadlines drift to shortly after the frames' arrival.
//! * [`LockStep`] follows the sensors: a tick runs when a new joint state has arrived, and its time is that state's.
//!   Virtual time stands still while there is nothing to do, so that a run depends on its goals only, not on when they
//!   were sent.

mod lockstep;
mod phase;
mod schedule;
mod spin;

pub use lockstep::LockStep;
pub use phase::{Arrivals, PhaseLock};
pub use schedule::{Schedule, TickStart};
pub use spin::SpinMargin;

use atas_core::Tick;
use rustix::thread::clock_nanosleep_absolute;
use rustix::time::{ClockId, Timespec};
use shm_bus::now_ns;
use shm_schemas::TickReport;

use crate::link::Link;
use crate::ports::InputPorts;

/// What the ticks follow.
#[derive(Debug)]
pub enum Pacer {
    /// The clock.
    Free(FreePacer),
    /// The sensors.
    LockStep(LockStep),
}

impl Pacer {
    /// Waits for the next tick and takes in the newest joint state. `None` when the loop shall end.
    pub fn wait(
        &mut self,
        ports: &mut InputPorts,
        link: &Link,
        pursues_goal: bool,
    ) -> Option<TickStart> {
        match self {
            Self::Free(pacer) => {
                let start = (!link.is_quitting()).then(|| pacer.wait());
                ports.take_joints();
                start
            }
            Self::LockStep(pacer) => pacer.wait(ports, link, pursues_goal),
        }
    }

    /// Learns from a tick when the next one should begin; `true` if the ticks are locked to the frames.
    pub fn learn(&mut self, start: &TickStart, report: &TickReport) -> bool {
        match self {
            Self::Free(pacer) => pacer.learn(start, report),
            Self::LockStep(_) => false,
        }
    }
}

/// Ticks by the clock.
#[derive(Debug)]
pub struct FreePacer {
    period_ns: u64,
    /// Begins with the first wait, so that what comes before it costs no tick.
    schedule: Option<Schedule>,
    margin: SpinMargin,
    phase: Option<PhaseLock>,
}

impl FreePacer {
    /// Ticks of this period (not 0), the first one a period after the first wait begins; spins at most `spin_max_ns`
    /// before each.
    #[must_use]
    pub fn new(period_ns: u64, spin_max_ns: u64) -> Self {
        Self {
            period_ns,
            schedule: None,
            margin: SpinMargin::new(spin_max_ns),
            phase: None,
        }
    }

    /// The same, locked to the frames: ticks at least `offset_ns` after their stamps.
    #[must_use]
    pub fn locked(self, offset_ns: u64) -> Self {
        Self {
            phase: Some(PhaseLock::new(self.period_ns, offset_ns)),
            ..self
        }
    }

    fn learn(&mut self, start: &TickStart, report: &TickReport) -> bool {
        let (Some(phase), Some(schedule)) = (&mut self.phase, &mut self.schedule) else {
            return false;
        };
        let Tick { now_ns, .. } = start.tick;
        let hands = report.hands.map(|hand| {
            let captured_ns = now_ns.checked_sub(hand.frame_age_ns)?;
            Some(Arrivals {
                captured_ns,
                frames: hand.frames,
            })
        });
        schedule.shift(phase.correct(start.tick, now_ns - start.late_ns, hands));
        phase.is_locked()
    }

    /// Sleeps, then spins, until the next deadline.
    fn wait(&mut self) -> TickStart {
        let period_ns = self.period_ns;
        let schedule = self
            .schedule
            .get_or_insert_with(|| Schedule::new(now_ns(), period_ns));
        let deadline_ns = schedule.deadline_ns();
        let awake_ns = deadline_ns.saturating_sub(self.margin.ns());
        if now_ns() < awake_ns {
            sleep_until(awake_ns);
            self.margin.observe(now_ns().saturating_sub(awake_ns));
        }
        schedule.begin(spin_until(deadline_ns))
    }
}

fn sleep_until(deadline_ns: u64) {
    let until = Timespec {
        tv_sec: (deadline_ns / 1_000_000_000).cast_signed(),
        tv_nsec: (deadline_ns % 1_000_000_000).cast_signed(),
    };
    // A signal interrupts the sleep; any other refusal leaves the spin to wait.
    while clock_nanosleep_absolute(ClockId::Monotonic, &until) == Err(rustix::io::Errno::INTR) {}
}

fn spin_until(deadline_ns: u64) -> u64 {
    loop {
        let now = now_ns();
        if now >= deadline_ns {
            return now;
        }
        std::hint::spin_loop();
    }
}
