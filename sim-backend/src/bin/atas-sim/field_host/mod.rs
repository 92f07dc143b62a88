//! `atas-sim field`: hosts the swarm's field on the bus.
//!
//! Every frame is published and answered once. At a frame rate, an answer missing at the next frame
//! counts as missed and the robots stand still. If the controlling process dies, robots stop within
//! one frame and continue when it returns. In lock-step the host waits for every answer. Both modes
//! wait for the first answer.

mod args;
mod onlookers;
mod ports;
mod report;

use std::sync::atomic::{AtomicBool, Ordering};

use shm_bus::{Bus, Realtime, now_ns};
use sim_backend::swarm::{Answer, Swarm};

use crate::failure::Failure;
use crate::free_run::sleep_until;
use crate::wait::Wait;
pub(crate) use args::FieldArgs;
use onlookers::Onlookers;
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
            onlookers: Onlookers::open(&bus)?,
            reporter: Reporter::new(args.format),
            asked_ns: 0,
        },
        stop: &stop,
    };
    let pace = args.pace();
    tracing::info!(bus = %args.bus, pace, "hosting the field; waiting for an agents process");
    let late_periods = if args.lockstep {
        host.in_step()?
    } else {
        host.at_rate(args.period_ns())?
    };
    host.field.reporter.end(late_periods)
}

struct Host<'a> {
    ports: Ports,
    field: Field,
    stop: &'a AtomicBool,
}

struct Field {
    swarm: Swarm,
    onlookers: Onlookers,
    reporter: Reporter,
    /// Time of the last sensor publication.
    asked_ns: u64,
}

impl Host<'_> {
    /// Runs one frame per answer; no period is late.
    fn in_step(&mut self) -> Result<u64, Failure> {
        while self.goes_on() && self.frame_in_step()? {}
        Ok(0)
    }

    /// Runs one frame per period at absolute deadlines. Returns the missed periods; they are
    /// skipped and the phase is kept.
    fn at_rate(&mut self, period_ns: u64) -> Result<u64, Failure> {
        let mut late_periods = 0;
        if !self.frame_in_step()? {
            return Ok(late_periods);
        }
        let mut deadline_ns = now_ns();
        while self.goes_on() {
            self.ask()?;
            deadline_ns += period_ns;
            while !self.stop.load(Ordering::Relaxed) && sleep_until(deadline_ns).is_err() {}
            let late = now_ns().saturating_sub(deadline_ns) / period_ns;
            late_periods += late;
            deadline_ns += late * period_ns;
            let answer = self
                .ports
                .answer()?
                .map_or(Answer::Missing, Answer::Commands);
            self.field.drive(answer)?;
        }
        Ok(late_periods)
    }

    /// Runs one frame; returns false if the process must end.
    fn frame_in_step(&mut self) -> Result<bool, Failure> {
        self.ask()?;
        let wait = Wait::begin();
        while !self.stop.load(Ordering::Relaxed) {
            if let Some(commands) = self.ports.answer()? {
                let answer = Answer::Commands(commands);
                self.field.drive(answer)?;
                return Ok(true);
            }
            wait.pause(|| self.greet())?;
        }
        Ok(false)
    }

    /// Publishes the sensors, then the previous frame to observers; the very first frame at once,
    /// because its answer may take long.
    fn ask(&mut self) -> Result<(), Failure> {
        let Field {
            swarm,
            onlookers,
            asked_ns,
            ..
        } = &mut self.field;
        *asked_ns = self.ports.publish(swarm)?;
        if onlookers.know_nothing() {
            onlookers.note(swarm, Answer::Missing, *asked_ns);
        }
        onlookers.tell()
    }

    fn greet(&self) -> Result<(), Failure> {
        self.ports.greet()?;
        self.field.onlookers.greet()
    }

    fn goes_on(&self) -> bool {
        !self.field.swarm.is_over() && !self.stop.load(Ordering::Relaxed)
    }
}

impl Field {
    /// Simulates one frame; reports the end of a trial to observers at once.
    fn drive(&mut self, answer: Answer<'_>) -> Result<(), Failure> {
        if self.onlookers.are_due(self.asked_ns) {
            self.onlookers.note(&self.swarm, answer, self.asked_ns);
        }
        let ended = self.swarm.advance(answer);
        if ended.is_some() {
            self.onlookers.note(&self.swarm, Answer::Missing, now_ns());
            self.onlookers.tell()?;
        }
        self.reporter.note(ended)
    }
}
