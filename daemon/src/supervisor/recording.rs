//! Publishes what a recorder needs: how the run began, and what every tick took in.

use robot_model::RobotFiles;
use shm_bus::{Bus, BusError, Publisher};
use shm_schemas::{RunHeader, Stamp, Text, TickInputs, service};

use super::SupervisorState;
use crate::input_log::LogReader;

/// The publishers, open only while recording is switched on.
#[derive(Debug)]
pub(super) struct RecordStream {
    headers: Publisher<RunHeader>,
    inputs: Publisher<TickInputs>,
}

impl RecordStream {
    /// Opens the streams and publishes the header.
    pub(super) fn open(bus: &Bus, state: &SupervisorState) -> Result<Self, BusError> {
        let stream = Self {
            headers: bus.publisher(service::RUN_HEADER)?,
            inputs: bus.publisher(service::TICK_INPUTS)?,
        };
        stream.headers.send(&header(state))?;
        Ok(stream)
    }

    /// Publishes the parts that wait, and lets recorders that came late have the header.
    pub(super) fn publish(&self, input_log: &mut LogReader) {
        while let Some(part) = input_log.next_part() {
            super::telemetry::report_failure(self.inputs.send(&part));
            input_log.give_back(part);
        }
        super::telemetry::report_failure(self.headers.connect_readers());
    }
}

fn header(state: &SupervisorState) -> Box<RunHeader> {
    let config = &state.config;
    let mut header: Box<RunHeader> = Box::default();
    header.stamp = Stamp {
        captured_ns: state.started_ns,
        ..Stamp::default()
    };
    header.version = Text::new(env!("CARGO_PKG_VERSION"));
    header.config_hash = state.config_hash;
    header.robot = Text::new(&config.robot.model);
    // 0 for a robot whose files have gone since the start.
    header.robot_hash = RobotFiles::find(&config.robot.model).map_or(0, |files| files.hash());
    header.rate_hz = config.realtime.rate_hz;
    header.flags = state.flags;
    header.config = Text::new(&config.text());
    atas_core::record::write_origin(&mut header, &state.robot, &state.wiring, &config.settings());
    header
}
