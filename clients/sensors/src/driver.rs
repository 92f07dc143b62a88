//! The OptoForce process: device → decoder → continuity → stamps → output.
//!
//! In: bytes from a [`Device`]. Out: readings to an [`Output`], as they come, and a [`Health`]
//! report ten times a second. One thread,
//! no allocation per frame. A stop request ends it within [`POLL`]; the device is then told to stop sending.

use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use crate::device::{Device, Input};
use crate::failure::Failure;
use crate::intake::Intake;
use crate::output::{Health, Output};
use crate::stamping::Stamper;
use crate::wire::optoforce::{BAUD, Configuration, Kind, STOP};

/// How long one read waits, and so how soon a stop request is seen. Ours; signals also interrupt the wait.
pub const POLL: Duration = Duration::from_millis(50);
/// How long the device may take to acknowledge. Ours: a hundred times what a device needs at 1 MBd.
pub const ACKNOWLEDGE_WITHIN: Duration = Duration::from_secs(1);
/// A device that sends nothing for so long is reported as not alive. Ours: ten frames of the slowest rate.
pub const SILENCE: Duration = Duration::from_secs(1);
/// Time between two health reports (bus convention for sensors: about 10 Hz).
pub const REPORT_EVERY: Duration = Duration::from_millis(100);
/// Reports between two log lines about damage. Ours: at most one line a second.
const REPORTS_PER_LOG: u32 = 10;
/// Time between two attempts to reconnect. Ours.
const RETRY_EVERY: Duration = Duration::from_millis(500);
/// Bytes per read: 41 ms of the fastest stream, and the size of the kernel's terminal buffer.
const READ_BYTES: usize = 4096;

/// What to run.
#[derive(Clone, Debug)]
pub struct Settings {
    /// Path of the device.
    pub device: PathBuf,
    /// What to tell the device; `None` for a stream that is only read.
    pub configuration: Option<Configuration>,
    /// What the device sends.
    pub kind: Kind,
    /// Nominal time between two frames, ns.
    pub period_ns: u64,
    /// Whether a regular file may be decoded.
    pub recording_allowed: bool,
    /// Whether to wait for a device that is missing or goes away.
    pub reconnect: bool,
}

/// Runs until a stop request, the end of a recording, or a failure. The last report is sent in every case.
///
/// # Errors
/// Everything that [`Failure`] names except contradictory arguments.
pub fn run(
    settings: &Settings,
    output: &mut dyn Output,
    clock: fn() -> u64,
    stop: &AtomicBool,
) -> (Health, Result<(), Failure>) {
    let mut driver = Driver::new(settings, output, clock, stop);
    let outcome = driver.run();
    let goodbye = driver.report(false);
    (driver.health, outcome.and(goodbye))
}

struct Driver<'a> {
    settings: &'a Settings,
    output: &'a mut dyn Output,
    clock: fn() -> u64,
    stop: &'a AtomicBool,
    intake: Intake,
    stamper: Stamper,
    health: Health,
    reported: Health,
    reports: u32,
    next_report_ns: u64,
    last_data_ns: u64,
}

impl<'a> Driver<'a> {
    fn new(
        settings: &'a Settings,
        output: &'a mut dyn Output,
        clock: fn() -> u64,
        stop: &'a AtomicBool,
    ) -> Self {
        Self {
            settings,
            output,
            clock,
            stop,
            intake: Intake::new(settings.kind),
            stamper: Stamper::new(settings.period_ns),
            health: Health::default(),
            reported: Health::default(),
            reports: 0,
            next_report_ns: 0,
            last_data_ns: 0,
        }
    }

    fn run(&mut self) -> Result<(), Failure> {
        loop {
            match self.connect_and_serve() {
                Err(failure) if self.settings.reconnect && failure.may_pass() => {
                    tracing::warn!("{failure}; trying again");
                    self.wait_for_retry()?;
                }
                outcome => return outcome,
            }
            if self.is_stopped() {
                return Ok(());
            }
        }
    }

    fn connect_and_serve(&mut self) -> Result<(), Failure> {
        let mut device = self.open()?;
        self.intake
            .begin_stream(self.settings.configuration.is_some());
        if let Some(configuration) = self.settings.configuration {
            device
                .write(&configuration.to_bytes())
                .map_err(|error| self.unconfigured(error.to_string()))?;
        }
        let outcome = self.serve(&mut device);
        if self.settings.configuration.is_some() && self.is_stopped() {
            // The device may be gone already; that is no reason not to stop.
            let _ = device.write(&STOP);
        }
        outcome
    }

    fn open(&self) -> Result<Device, Failure> {
        let refuse = |reason: &str| Failure::Open {
            device: self.name(),
            reason: reason.to_owned(),
        };
        let device = Device::open(&self.settings.device, BAUD).map_err(|reason| refuse(&reason))?;
        if device.is_recording() && !self.settings.recording_allowed {
            return Err(refuse(
                "it is a regular file, needs a terminal or a FIFO; add --dry-run to decode a recording",
            ));
        }
        if !device.is_terminal() && self.settings.configuration.is_some() {
            return Err(refuse(
                "only a terminal can be configured; add --no-configure to read the stream as it is",
            ));
        }
        tracing::info!("reading {}", self.name());
        Ok(device)
    }

    /// Reads until a stop request, the end or a failure.
    fn serve(&mut self, device: &mut Device) -> Result<(), Failure> {
        let mut buffer = [0; READ_BYTES];
        let deadline_ns = (self.clock)() + nanos(ACKNOWLEDGE_WITHIN);
        while !self.is_stopped() {
            let input = device.read(&mut buffer, POLL);
            let now_ns = (self.clock)();
            match input {
                Input::Bytes(length) => self.take(&buffer[..length], now_ns)?,
                Input::Quiet => {}
                Input::End => return self.end_stream(now_ns),
                Input::Gone(error) => {
                    self.end_stream(now_ns)?;
                    return Err(Failure::Gone {
                        device: self.name(),
                        reason: error.to_string(),
                    });
                }
            }
            if self.intake.awaits_acknowledgement() && now_ns > deadline_ns {
                return Err(self.unanswered());
            }
            self.report_when_due(now_ns)?;
        }
        self.end_stream((self.clock)())
    }

    fn take(&mut self, bytes: &[u8], now_ns: u64) -> Result<(), Failure> {
        self.last_data_ns = now_ns;
        self.intake.push(bytes);
        self.deliver(now_ns)
    }

    fn end_stream(&mut self, now_ns: u64) -> Result<(), Failure> {
        self.intake.finish();
        self.deliver(now_ns)
    }

    /// Stamps and hands on what the intake gathered.
    fn deliver(&mut self, now_ns: u64) -> Result<(), Failure> {
        if let Some(status) = self.intake.refusal() {
            return Err(self.unconfigured(format!(
                "it refused with status {status}; check rate and filter"
            )));
        }
        if let Some(found) = self.intake.wrong_kind() {
            return Err(Failure::WrongKind {
                device: self.name(),
                found,
                expected: self.settings.kind,
            });
        }
        let stamps = self.stamper.spread(now_ns, self.intake.batch.len());
        for (reading, captured_ns) in self.intake.batch.iter_mut().zip(stamps) {
            reading.captured_ns = captured_ns;
        }
        self.output.readings(&self.intake.batch)?;
        self.intake.batch.clear();
        Ok(())
    }

    fn report_when_due(&mut self, now_ns: u64) -> Result<(), Failure> {
        if now_ns < self.next_report_ns {
            return Ok(());
        }
        self.next_report_ns = now_ns + nanos(REPORT_EVERY);
        let silent_ns = now_ns.saturating_sub(self.last_data_ns);
        let alive = silent_ns < nanos(SILENCE);
        if self.health.alive && !alive {
            tracing::warn!("{} is silent", self.name());
        }
        self.report(alive)
    }

    fn report(&mut self, alive: bool) -> Result<(), Failure> {
        self.health = Health {
            alive,
            ..self.intake.health()
        };
        self.reports += 1;
        if self.reports.is_multiple_of(REPORTS_PER_LOG) && is_worse(&self.reported, &self.health) {
            tracing::warn!("{}: {}", self.name(), self.health);
            self.reported = self.health;
        }
        self.output.health(&self.health)
    }

    fn wait_for_retry(&mut self) -> Result<(), Failure> {
        let until_ns = (self.clock)() + nanos(RETRY_EVERY);
        while (self.clock)() < until_ns && !self.is_stopped() {
            std::thread::sleep(POLL);
            self.report_when_due((self.clock)())?;
        }
        Ok(())
    }

    fn is_stopped(&self) -> bool {
        self.stop.load(Ordering::Relaxed)
    }

    fn name(&self) -> String {
        self.settings.device.display().to_string()
    }

    fn unconfigured(&self, reason: String) -> Failure {
        Failure::Configure {
            device: self.name(),
            reason,
        }
    }

    fn unanswered(&self) -> Failure {
        let bytes = self.intake.health().bytes;
        self.unconfigured(format!(
            "no acknowledgement within {} s, {} bytes and {} valid frames came; check that it is an OMD sensor, or add \
             --no-configure to read a stream that cannot be configured",
            ACKNOWLEDGE_WITHIN.as_secs(),
            bytes.received,
            bytes.frames,
        ))
    }
}

fn is_worse(before: &Health, now: &Health) -> bool {
    before.bytes.junk < now.bytes.junk
        || before.continuity != now.continuity
        || before.device_errors < now.device_errors
}

fn nanos(duration: Duration) -> u64 {
    u64::try_from(duration.as_nanos()).unwrap_or(u64::MAX)
}
