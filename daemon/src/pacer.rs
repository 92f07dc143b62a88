//! When the next tick begins.
//!
//! * [`FreePacer`] follows the machine's clock: absolute deadlines, sleep until shortly before, then spin. A late tick
//!   is never caught up: whole periods that have passed are skipped and counted, the phase is kept. With a [`PhaseLock`]
//!   the deadlines drift to the frames' arrival, and the spin looks for the frames: a tick begins when what it awaits is
//!   there, at the latest a little after its deadline.
//! * [`LockStep`] follows the sensors: a tick runs when a new joint state has arrived, and its time is that state's.
//!   Virtual time stands still while there is nothing to do, so that a run depends on its goals only, not on when they
//!   were sent. A client for which more than the goals goes on says how far it may go without any (`ControlOp::ADVANCE`).

mod lockstep;
mod phase;
mod schedule;
mod spin;

pub use lockstep::LockStep;
pub use phase::{Arrivals, Awaited, PhaseLock};
pub use schedule::{Began, Schedule, TickStart};
pub use spin::SpinMargin;

use rustix::thread::clock_nanosleep_absolute;
use rustix::time::{ClockId, Timespec};
use shm_bus::now_ns;

use crate::link::TickEnd;
use crate::ports::{InputPorts, STREAMS};

/// What the ticks follow.
#[derive(Debug)]
pub enum Pacer {
    /// The clock.
    Free(FreePacer),
    /// The sensors.
    LockStep(LockStep),
}

impl Pacer {
    /// Waits for the next tick. `None` when the loop shall end. Where there is time
    /// between waking up and the tick, `warm` is called once, to bring into the caches what the tick will need.
    pub fn wait(
        &mut self,
        ports: &mut InputPorts,
        link: &TickEnd,
        pursues_goal: bool,
        warm: impl FnOnce(&InputPorts),
    ) -> Option<TickStart> {
        match self {
            Self::Free(pacer) => (!link.is_quitting()).then(|| pacer.wait(ports, warm)),
            Self::LockStep(pacer) => pacer.wait(ports, link, pursues_goal),
        }
    }

    /// Takes in what the tick shall use. In lock-step the joint state is in already: the tick's time is its own, and a newer
    /// one is the next tick's.
    pub fn take_in(&self, ports: &mut InputPorts) {
        match self {
            Self::Free(_) => ports.look(),
            Self::LockStep(_) => {
                ports.look_for_frames();
                ports.look_for_targets();
            }
        }
    }

    /// Whether the ticks follow the clock.
    #[must_use]
    pub fn is_free(&self) -> bool {
        matches!(self, Self::Free(_))
    }

    /// Learns from a tick when the next one should begin; `true` if the ticks are locked to the frames.
    pub fn learn(&mut self, start: &TickStart, streams: [Option<Arrivals>; STREAMS]) -> bool {
        match self {
            Self::Free(pacer) => pacer.learn(start, streams),
            Self::LockStep(_) => false,
        }
    }
}

/// What warming the caches takes until it is known, ns (measured: 10 to 45 µs when cold). Ours.
const WARM_NS: u64 = 18_000;
/// The wait for what is late ends at this fraction of a period at the latest, whatever is configured: the tick itself
/// needs the rest. Ours.
const PATIENCE_PERIODS: u64 = 4;

/// Ticks by the clock.
#[derive(Debug)]
pub struct FreePacer {
    period_ns: u64,
    /// Begins with the first wait, so that what comes before it costs no tick.
    schedule: Option<Schedule>,
    margin: SpinMargin,
    /// What warming takes here: begun any later, it would outlast the deadline.
    warming: SpinMargin,
    phase: Option<PhaseLock>,
    patience_ns: u64,
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
            warming: SpinMargin::from(WARM_NS, spin_max_ns),
            phase: None,
            patience_ns: 0,
        }
    }

    /// The same, locked to the frames: they arrive about `lag_ns` after their stamps, and one that is late is awaited for
    /// at most `patience_ns`.
    #[must_use]
    pub fn locked(self, lag_ns: u64, patience_ns: u64) -> Self {
        Self {
            phase: Some(PhaseLock::new(self.period_ns, lag_ns)),
            patience_ns: patience_ns.min(self.period_ns / PATIENCE_PERIODS),
            ..self
        }
    }

    fn learn(&mut self, start: &TickStart, streams: [Option<Arrivals>; STREAMS]) -> bool {
        let (Some(phase), Some(schedule)) = (&mut self.phase, &mut self.schedule) else {
            return false;
        };
        schedule.shift(phase.correct(start, streams));
        phase.is_locked()
    }

    /// Sleeps, warms up, then looks and spins until the next tick may begin.
    fn wait(&mut self, ports: &mut InputPorts, warm: impl FnOnce(&InputPorts)) -> TickStart {
        let period_ns = self.period_ns;
        let schedule = self
            .schedule
            .get_or_insert_with(|| Schedule::new(now_ns(), period_ns));
        let deadline_ns = schedule.deadline_ns();
        let awaited = self
            .phase
            .map_or_else(Awaited::default, |phase| phase.awaited(deadline_ns));
        let early_ns = (self.margin.ns() + self.warming.ns()).min(self.margin.max_ns());
        let awake_ns = deadline_ns.saturating_sub(early_ns);
        if now_ns() < awake_ns {
            sleep_until(awake_ns);
            self.margin.observe(now_ns().saturating_sub(awake_ns));
        }
        let begin_ns = now_ns();
        if begin_ns + self.warming.ns() < deadline_ns {
            warm(ports);
            self.warming.observe(now_ns().saturating_sub(begin_ns));
        }
        ports.begin();
        let (now, began, late_ns) = if awaited.is_something() {
            look_until(ports, &awaited, deadline_ns, self.patience_ns)
        } else {
            let now = spin_until(deadline_ns);
            (now, Began::AtDeadline, now.saturating_sub(deadline_ns))
        };
        schedule.begin(now, began, late_ns)
    }
}

/// Looks until what is awaited has come, or until the latest moment. Returns when that was, why it ended, and by how much
/// it missed its moment. What comes is left where it is: to take it in is the tick's work.
fn look_until(
    ports: &mut InputPorts,
    awaited: &Awaited,
    deadline_ns: u64,
    patience_ns: u64,
) -> (u64, Began, u64) {
    // What waits already may be of the frame before; what comes from now on is new.
    ports.look();
    let missing = awaited.missing(&ports.captured_ns());
    let mut looked_ns = now_ns();
    if missing == [false; STREAMS] {
        return (
            looked_ns,
            Began::FoundWaiting,
            looked_ns.saturating_sub(deadline_ns),
        );
    }
    let latest_ns = deadline_ns + patience_ns;
    loop {
        let has_come = ports.have_news(&missing);
        let now = now_ns();
        if has_come {
            return (now, Began::OnArrival, now - looked_ns);
        }
        if now >= latest_ns {
            return (now, Began::InVain, now - latest_ns);
        }
        looked_ns = now;
        std::hint::spin_loop();
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
