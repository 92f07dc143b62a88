//! Supervisor, the non-real-time side: everything that may wait, allocate, log or fail without
//! effect on the robot.
//!
//! Every 4 ms it reads the records of the ticks ([`SupervisorSide`]) and publishes them. It also
//! answers goals and control requests, cleans up dead peers, feeds the service manager's watchdog
//! and polls the signals.
//!
//! * **Invariants:** nothing here can delay a tick. Every list is bounded. A goal gets exactly one
//!   final update.
//! * Goals are checked here for form and reach; the controller decides whether one may start now.

mod checker;
mod controls;
mod event_log;
mod flight;
mod goals;
mod recording;
mod service;
mod state;
mod telemetry;

pub use controls::execute_control;
pub use service::Signals;
pub use state::SupervisorState;

use std::io;
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use atas_core::OperatorRequest;
use shm_bus::{Bus, BusError, now_ns};
use shm_schemas::Reason;

use crate::link::{Notification, SupervisorSide};
use controls::ControlService;
use event_log::EventLog;
use flight::FlightRecorder;
use goals::GoalService;
use recording::RecordStream;
use service::ServiceManager;
use telemetry::Telemetry;

/// Pause between two rounds, short against the 100 ms that a person notices. A round takes about 15
/// µs. Design choice.
const ROUND_PERIOD: Duration = Duration::from_millis(4);
/// Interval of the clean-up after dead peers (bus design: 100 to 500 ms).
const CLEAN_INTERVAL: Duration = Duration::from_millis(250);
/// Time limit from a signal to the end: the ramp to a stop takes some tens of milliseconds (fault
/// catalogue F60: 200 ms).
const STOP_TIMEOUT: Duration = Duration::from_millis(150);
/// Commands at rest published after the ramp, so that the robot receives them.
const REST_TICKS: u32 = 5;

/// The supervisor, with its own thread and ports.
#[derive(Debug)]
pub struct Supervisor {
    bus: Bus,
    link: SupervisorSide,
    state: SupervisorState,
    goals: GoalService,
    controls: ControlService,
    telemetry: Telemetry,
    event_log: EventLog,
    flight: FlightRecorder,
    recording: RecordStream,
    manager: ServiceManager,
    signals: Signals,
    resting_ticks: u32,
}

/// Error at the start of the supervisor.
#[derive(Debug, thiserror::Error)]
pub enum OpenError {
    /// Bus.
    #[error(transparent)]
    Bus(#[from] BusError),
    /// Thread creation.
    #[error("could not start a thread: {0}")]
    Thread(#[from] io::Error),
}

/// Unexpected end of the tick thread.
#[derive(Debug, thiserror::Error)]
#[error("the tick thread ended unexpectedly: {0}; restart the daemon and report this")]
pub struct TickThreadEnded(String);

impl Supervisor {
    /// Opens the ports of the supervisor.
    ///
    /// # Errors
    /// [`OpenError`] if a port or a thread cannot be created.
    pub fn open(
        bus: Bus,
        link: SupervisorSide,
        state: SupervisorState,
        signals: Signals,
    ) -> Result<Self, OpenError> {
        let state_directory = std::env::var_os("STATE_DIRECTORY");
        let recording = &state.config.recording;
        let flight_folder = recording.flight_folder(state_directory.as_deref());
        Ok(Self {
            goals: GoalService::open(&bus, &state)?,
            controls: ControlService::open(&bus)?,
            telemetry: Telemetry::open(&bus)?,
            event_log: EventLog::default(),
            flight: FlightRecorder::new(flight_folder)?,
            recording: RecordStream::open(&bus, &state)?,
            manager: ServiceManager::from_environment(),
            resting_ticks: 0,
            bus,
            link,
            state,
            signals,
        })
    }

    /// Runs until a signal requests a stop and the robot is at rest.
    ///
    /// # Errors
    /// [`TickThreadEnded`].
    pub fn run(&mut self, ticks: &JoinHandle<()>) -> Result<(), TickThreadEnded> {
        let mut clean_at = Instant::now();
        let mut stop_by: Option<Instant> = None;
        loop {
            self.run_round();
            if Instant::now() >= clean_at {
                self.bus.clean_dead();
                clean_at = Instant::now() + CLEAN_INTERVAL;
            }
            if ticks.is_finished() {
                return Err(TickThreadEnded(
                    crate::panics::take_message().unwrap_or_default(),
                ));
            }
            if stop_by.is_none() && self.signals.stop_requested() {
                stop_by = Some(self.begin_stop());
            }
            let at_rest = self.resting_ticks >= REST_TICKS;
            if stop_by.is_some_and(|by| at_rest || Instant::now() >= by) {
                return Ok(());
            }
            std::thread::sleep(ROUND_PERIOD);
        }
    }

    /// Publishes the remaining records after the last tick.
    pub fn finish(&mut self) {
        self.process_records();
    }

    fn run_round(&mut self) {
        self.link.report_alive(now_ns());
        self.process_records();
        let Self {
            goals,
            controls,
            state,
            link,
            signals,
            manager,
            ..
        } = self;
        goals.serve(state, link);
        controls.serve(state, link);
        if signals.take_reload_request() {
            manager.reloading();
            match state.reload(link) {
                Ok(_) => tracing::info!("configuration reloaded"),
                Err(why) => tracing::error!("configuration not changed: {why}"),
            }
            manager.ready();
        }
        manager.report_ticks(state.record_count);
        self.telemetry.publish_view(&self.state, &mut self.link);
        self.telemetry.publish_status(&self.state, &mut self.link);
    }

    fn process_records(&mut self) {
        while let Some(record) = self.link.next_record() {
            self.state.update(&record);
            self.telemetry.publish_record(&record);
            self.flight.record(&record.report);
            self.event_log.check_record(&record);
            let stopped = self.signals.stop_requested() && record.at_rest;
            self.resting_ticks = if stopped { self.resting_ticks + 1 } else { 0 };
        }
        while let Some(news) = self.link.next_notification() {
            self.telemetry
                .publish_notified_status(&self.state, &mut self.link);
            match news {
                Notification::Taken(ticket) => self.controls.complete(ticket),
                Notification::Goal(update) => self.goals.forward_update(&update),
            }
        }
        while let Some(event) = self.link.next_event() {
            self.telemetry.publish_event(&event);
            self.event_log.write_event(&event, &self.state.robot);
            self.flight.save_on_fault(&event);
        }
        self.recording.publish(self.link.input_log());
        self.event_log.check_dropped(self.link.dropped());
    }

    fn begin_stop(&mut self) -> Instant {
        tracing::info!("stop requested by a signal; ramping to a stop");
        self.manager.stopping();
        self.resting_ticks = 0;
        // The queue of stops has room: no other source stops in every tick.
        let _ticket = self.link.request(OperatorRequest::Stop(Reason::Shutdown));
        Instant::now() + STOP_TIMEOUT
    }
}
