//! Publishes the run header, and the inputs of every tick if recording is on.

use std::borrow::Cow;

use robot_model::{RobotFiles, shipped_names};
use shm_bus::{Bus, BusError, Publisher};
use shm_schemas::{RunHeader, Stamp, Text, TickInputs, service};

use super::SupervisorState;
use crate::input_log::LogReader;

#[derive(Debug)]
pub(super) struct RecordStream {
    headers: Publisher<RunHeader>,
    /// Open only if recording is on.
    inputs: Option<Publisher<TickInputs>>,
}

impl RecordStream {
    /// Opens the streams and publishes the header.
    pub(super) fn open(bus: &Bus, state: &SupervisorState) -> Result<Self, BusError> {
        let records = state.config.recording.stream;
        let inputs = records.then(|| bus.publisher(service::TICK_INPUTS));
        let stream = Self {
            headers: bus.publisher(service::RUN_HEADER)?,
            inputs: inputs.transpose()?,
        };
        stream.headers.send(&header(state))?;
        Ok(stream)
    }

    /// Publishes queued parts, and delivers the header to new readers.
    pub(super) fn publish(&self, input_log: Option<&mut LogReader>) {
        if let (Some(inputs), Some(input_log)) = (&self.inputs, input_log) {
            while let Some(part) = input_log.next_part() {
                super::telemetry::log_failure(inputs.send(&part));
                input_log.recycle(part);
            }
        }
        super::telemetry::log_failure(self.headers.connect_readers());
    }
}

fn header(state: &SupervisorState) -> Box<RunHeader> {
    let config = &state.config;
    let mut header: Box<RunHeader> = Box::default();
    header.stamp = Stamp {
        captured_ns: state.started_ns,
        ..Stamp::default()
    };
    header.version = Text::new(atas_core::VERSION);
    header.config_hash = state.config_hash;
    header.robot = Text::new(&robot(&config.robot.model));
    // 0 if the robot's files have disappeared since the start.
    header.robot_hash = RobotFiles::find(&config.robot.model).map_or(0, |files| files.hash());
    header.rate_hz = config.realtime.rate_hz;
    header.flags = state.flags;
    header.config = Text::new(&config.text());
    atas_core::record::write_origin(
        &mut header,
        &state.robot,
        &state.sensor_setup,
        &config.settings(),
    );
    header
}

/// Robot name for other processes: a shipped name, or the absolute path of the robot file.
fn robot(model: &str) -> Cow<'_, str> {
    if shipped_names().any(|name| name == model) {
        return Cow::Borrowed(model);
    }
    let whole = std::path::absolute(model);
    whole.map_or(Cow::Borrowed(model), |path| {
        Cow::Owned(path.display().to_string())
    })
}
