//! Start time of the next tick.
//!
//! * [`FreePacer`] follows the clock: absolute deadlines, sleep until shortly before, then spin.
//!   Late ticks are not made up: whole missed periods are skipped and counted, and the phase is
//!   kept. With a [`PhaseLock`] the deadlines drift to the arrival of the frames. The spin then
//!   polls for the awaited payloads, at most until shortly after the deadline.
//! * [`LockStep`] follows the sensors: a tick runs on each new joint state, at that state's time.
//!   Virtual time stands still without work, so that a run depends on its goals and not on when
//!   they were sent. A client may let it advance without goals (`ControlOp::ADVANCE`).

mod lockstep;
mod phase;
mod schedule;
mod spin;

pub use lockstep::LockStep;
pub use phase::{Arrivals, Awaited, PhaseLock};
pub use schedule::{Schedule, StartReason, TickStart};
pub use spin::SpinMargin;

use atas_core::Tick;
use rustix::thread::clock_nanosleep_absolute;
use rustix::time::{ClockId, Timespec};
use shm_bus::now_ns;

use crate::link::RealtimeSide;
use crate::ports::{InputPorts, STREAMS};

/// Time base of the ticks.
#[derive(Debug)]
pub enum Pacer {
    /// Clock.
    Free(FreePacer),
    /// Sensors.
    LockStep(LockStep),
}

impl Pacer {
    /// Waits for the next tick; `None` when the loop must end. Calls `warm_up` once if there is
    /// time after waking up.
    pub fn wait(
        &mut self,
        ports: &mut InputPorts,
        link: &RealtimeSide,
        pursues_goal: bool,
        warm: impl FnOnce(&InputPorts),
    ) -> Option<TickStart> {
        match self {
            Self::Free(pacer) => (!link.is_quitting()).then(|| pacer.wait(ports, warm)),
            Self::LockStep(pacer) => pacer.wait(ports, link, pursues_goal),
        }
    }

    /// Receives the inputs of the tick and returns its time. On the clock, the time is read
    /// afterwards: inputs that come while the thread waits for a core are not in the future. In
    /// lock-step the joint state is already received, because it sets the time.
    pub fn receive(&self, ports: &mut InputPorts, start: &TickStart) -> Tick {
        match self {
            Self::Free(_) => {
                ports.poll();
                Tick {
                    now_ns: now_ns(),
                    ..start.tick
                }
            }
            Self::LockStep(_) => {
                ports.poll_frames();
                ports.poll_targets();
                start.tick
            }
        }
    }

    /// Returns true if the ticks follow the clock.
    #[must_use]
    pub fn is_free(&self) -> bool {
        matches!(self, Self::Free(_))
    }

    /// Adapts the next deadline to a tick; returns true if the ticks are phase-locked to the
    /// frames.
    pub fn adapt(&mut self, start: &TickStart, streams: [Option<Arrivals>; STREAMS]) -> bool {
        match self {
            Self::Free(pacer) => pacer.adapt(start, streams),
            Self::LockStep(_) => false,
        }
    }
}

/// Initial estimate of the cache warm-up's duration, ns (measured: 10 to 45 µs when cold). Design
/// choice.
const WARM_UP_NS: u64 = 18_000;
/// Upper bound of the wait for late frames, as a divisor of the period: the tick needs the rest.
/// Design choice.
const WAIT_MAX_DIVISOR: u64 = 4;

/// Pacer that follows the clock.
#[derive(Debug)]
pub struct FreePacer {
    period_ns: u64,
    /// Created at the first wait, so that set-up time misses no tick.
    schedule: Option<Schedule>,
    margin: SpinMargin,
    /// Duration of the warm-up: a later start would pass the deadline.
    warm_up_margin: SpinMargin,
    phase: Option<PhaseLock>,
    wait_max_ns: u64,
}

impl FreePacer {
    /// Ticks with this period (not 0), the first one period after the first wait. Spins at most
    /// `spin_max_ns` before each.
    #[must_use]
    pub fn new(period_ns: u64, spin_max_ns: u64) -> Self {
        Self {
            period_ns,
            schedule: None,
            margin: SpinMargin::new(spin_max_ns),
            warm_up_margin: SpinMargin::starting_at(WARM_UP_NS, spin_max_ns),
            phase: None,
            wait_max_ns: 0,
        }
    }

    /// Adds a phase lock: frames arrive about `lag_ns` after their stamps, and a late one is
    /// awaited for at most `wait_max_ns`.
    #[must_use]
    pub fn with_phase_lock(self, lag_ns: u64, patience_ns: u64) -> Self {
        Self {
            phase: Some(PhaseLock::new(self.period_ns, lag_ns)),
            wait_max_ns: patience_ns.min(self.period_ns / WAIT_MAX_DIVISOR),
            ..self
        }
    }

    fn adapt(&mut self, start: &TickStart, streams: [Option<Arrivals>; STREAMS]) -> bool {
        let (Some(phase), Some(schedule)) = (&mut self.phase, &mut self.schedule) else {
            return false;
        };
        schedule.shift(phase.update(start, streams));
        phase.is_locked()
    }

    /// Sleeps, warms up, then polls or spins until the next tick may start.
    fn wait(&mut self, ports: &mut InputPorts, warm: impl FnOnce(&InputPorts)) -> TickStart {
        let period_ns = self.period_ns;
        let schedule = self
            .schedule
            .get_or_insert_with(|| Schedule::new(now_ns(), period_ns));
        let deadline_ns = schedule.deadline_ns();
        let awaited = self
            .phase
            .map_or_else(Awaited::default, |phase| phase.awaited(deadline_ns));
        let early_ns = (self.margin.ns() + self.warm_up_margin.ns()).min(self.margin.max_ns());
        let awake_ns = deadline_ns.saturating_sub(early_ns);
        if now_ns() < awake_ns {
            sleep_until(awake_ns);
            self.margin.observe(now_ns().saturating_sub(awake_ns));
        }
        let begin_ns = now_ns();
        if begin_ns + self.warm_up_margin.ns() < deadline_ns {
            warm(ports);
            self.warm_up_margin
                .observe(now_ns().saturating_sub(begin_ns));
        }
        ports.begin_tick();
        let (now, began, late_ns) = if awaited.is_any() {
            poll_until(ports, &awaited, deadline_ns, self.wait_max_ns)
        } else {
            let now = spin_until(deadline_ns);
            (
                now,
                StartReason::AtDeadline,
                now.saturating_sub(deadline_ns),
            )
        };
        schedule.begin(now, began, late_ns)
    }
}

/// Polls until the awaited payloads have arrived or the time limit is reached. Returns the time,
/// the reason of the start and the delay. Payloads stay queued for the tick.
fn poll_until(
    ports: &mut InputPorts,
    awaited: &Awaited,
    deadline_ns: u64,
    patience_ns: u64,
) -> (u64, StartReason, u64) {
    // Queued payloads may belong to the previous frame; later ones are new.
    ports.poll();
    let missing = awaited.missing(&ports.captured_ns());
    let mut looked_ns = now_ns();
    if missing == [false; STREAMS] {
        return (
            looked_ns,
            StartReason::AlreadyArrived,
            looked_ns.saturating_sub(deadline_ns),
        );
    }
    let latest_ns = deadline_ns + patience_ns;
    loop {
        let has_come = ports.have_payloads(&missing);
        let now = now_ns();
        if has_come {
            return (now, StartReason::OnArrival, now - looked_ns);
        }
        if now >= latest_ns {
            return (now, StartReason::TimedOut, now - latest_ns);
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
    // A signal interrupts the sleep; after any other error the spin waits.
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

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use shm_bus::{Bus, FreshBus, Realtime};
    use shm_schemas::{HandFrame, Stamp, service};

    use super::*;

    #[test]
    fn frame_that_comes_while_the_tick_waits_for_a_core_is_not_in_the_future() {
        let name = FreshBus::new("stall");
        let bus = Bus::open(&name, "test", Realtime::No).expect("a bus");
        let mut ports = InputPorts::open(&bus).expect("ports");
        let sensor = bus.publisher(service::HAND_FRAME[0]).expect("a publisher");
        let mut pacer = FreePacer::new(1_000_000, 0);
        let start = pacer.wait(&mut ports, |_| ());
        std::thread::sleep(Duration::from_millis(5));
        let frame = HandFrame {
            stamp: Stamp {
                captured_ns: now_ns(),
                ..Stamp::default()
            },
            ..HandFrame::default()
        };
        sensor.send(&frame).expect("sent");
        let tick = Pacer::Free(pacer).receive(&mut ports, &start);
        let [captured_ns, ..] = ports.captured_ns();
        assert_eq!(captured_ns, frame.stamp.captured_ns);
        assert!(tick.now_ns >= captured_ns, "{tick:?}: {captured_ns} ns");
        assert_eq!(tick.index, start.tick.index);
    }
}
