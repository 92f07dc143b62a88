//! `atas-sim field`: hosts the swarm's field on the bus.
//!
//! Every frame is published and answered once. At a frame rate, an answer missing at the next frame
//! counts as missed and the robots stand still. If the controlling process dies, robots stop within
//! one frame and continue when it returns. In lock-step the host waits for every answer. Both modes
//! wait for the first answer.

mod args;
mod observers;
mod ports;
mod report;

use std::sync::atomic::{AtomicBool, Ordering};

use shm_bus::{Bus, Realtime, now_ns};
use sim_backend::swarm::{FrameCommands, Swarm};

use crate::failure::Failure;
use crate::free_run::sleep_until;
use crate::wait::Wait;
pub(crate) use args::FieldArgs;
use observers::Observers;
use ports::Ports;
use report::Reporter;

/// Hosts the field until all trials are over or a signal arrives.
pub(crate) fn run(args: &FieldArgs) -> Result<(), Failure> {
    let stop = crate::stop_on_signal()?;
    let swarm = Swarm::new(args.settings()?)?;
    let bus = Bus::open(&args.bus, "atas-sim", Realtime::Yes)?;
    let mut host = Host {
        ports: Ports::open(&bus)?,
        field: Field {
            swarm,
            observers: Observers::open(&bus)?,
            reporter: Reporter::new(args.format),
            published_ns: 0,
        },
        stop: &stop,
    };
    let pace = args.pace();
    tracing::info!(bus = %args.bus, pace, "hosting the field; waiting for an agents process");
    let late_periods = if args.lockstep {
        host.run_lockstep()?
    } else {
        host.run_at_rate(args.period_ns())?
    };
    host.field.reporter.print_totals(late_periods)
}

struct Host<'a> {
    ports: Ports,
    field: Field,
    stop: &'a AtomicBool,
}

struct Field {
    swarm: Swarm,
    observers: Observers,
    reporter: Reporter,
    /// Time of the last sensor publication.
    published_ns: u64,
}

impl Host<'_> {
    /// Runs one frame per answer; no period is late.
    fn run_lockstep(&mut self) -> Result<u64, Failure> {
        while self.is_running() && self.frame_in_step()? {}
        Ok(0)
    }

    /// Runs one frame per period at absolute deadlines. Returns the missed periods; they are
    /// skipped and the phase is kept.
    fn run_at_rate(&mut self, period_ns: u64) -> Result<u64, Failure> {
        let mut late_periods = 0;
        if !self.frame_in_step()? {
            return Ok(late_periods);
        }
        let mut deadline_ns = now_ns();
        while self.is_running() {
            self.publish_sensors()?;
            deadline_ns += period_ns;
            while !self.stop.load(Ordering::Relaxed) && sleep_until(deadline_ns).is_err() {}
            let late = now_ns().saturating_sub(deadline_ns) / period_ns;
            late_periods += late;
            deadline_ns += late * period_ns;
            let answer = self
                .ports
                .answer()?
                .map_or(FrameCommands::Missing, FrameCommands::Commands);
            self.field.drive(answer)?;
        }
        Ok(late_periods)
    }

    /// Runs one frame; returns false if the process must end.
    fn frame_in_step(&mut self) -> Result<bool, Failure> {
        self.publish_sensors()?;
        let wait = Wait::begin();
        while !self.stop.load(Ordering::Relaxed) {
            if let Some(commands) = self.ports.answer()? {
                let answer = FrameCommands::Commands(commands);
                self.field.drive(answer)?;
                return Ok(true);
            }
            wait.pause(|| self.connect_readers())?;
        }
        Ok(false)
    }

    /// Publishes the sensors, then the previous frame to observers; the very first frame at once,
    /// because its answer may take long.
    fn publish_sensors(&mut self) -> Result<(), Failure> {
        let Field {
            swarm,
            observers: onlookers,
            published_ns: asked_ns,
            ..
        } = &mut self.field;
        *asked_ns = self.ports.publish(swarm)?;
        if onlookers.have_no_frame() {
            onlookers.record(swarm, FrameCommands::Missing, *asked_ns);
        }
        onlookers.publish()
    }

    fn connect_readers(&self) -> Result<(), Failure> {
        self.ports.connect_readers()?;
        self.field.observers.connect_readers()
    }

    fn is_running(&self) -> bool {
        !self.field.swarm.is_over() && !self.stop.load(Ordering::Relaxed)
    }
}

impl Field {
    /// Simulates one frame; reports the end of a trial to observers at once.
    fn drive(&mut self, answer: FrameCommands<'_>) -> Result<(), Failure> {
        if self.observers.is_frame_due(self.published_ns) {
            self.observers
                .record(&self.swarm, answer, self.published_ns);
        }
        let ended = self.swarm.advance(answer);
        if ended.is_some() {
            self.observers
                .record(&self.swarm, FrameCommands::Missing, now_ns());
            self.observers.publish()?;
        }
        self.reporter.record(ended)
    }
}
