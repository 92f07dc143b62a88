//! Publishes what a recorder needs: how the run began, and what every tick took in.

use shm_bus::{Bus, BusError, Publisher};
use shm_schemas::layout::{FNV_OFFSET, fnv1a};
use shm_schemas::{RunHeader, Stamp, Text, TickInputs, service};

use super::SupervisorState;
use crate::config::BUILT_IN;
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
    header.robot = Text::new(&config.robot.urdf);
    header.robot_hash = robot_hash(&config.robot.urdf);
    header.rate_hz = config.realtime.rate_hz;
    header.flags = state.flags;
    header.config = Text::new(&config.text());
    atas_core::record::write_origin(&mut header, &state.robot, &state.wiring, &config.settings());
    header
}

/// 0 for the built-in robot, and for a file that has gone since the start.
fn robot_hash(urdf: &str) -> u64 {
    if urdf == BUILT_IN {
        return 0;
    }
    std::fs::read(urdf).map_or(0, |text| fnv1a(FNV_OFFSET, &text))
}
