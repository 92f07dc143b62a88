//! Settings of each stream: one row per service, identical in every process.
//!
//! All streams overflow safely: a slow reader loses the oldest payloads, a writer never waits. The
//! streams of the 1 kHz loop have few peers: one that joins or leaves causes a memory map in the
//! others' next call (up to 481 µs measured). Observers read the streams of the daemon's
//! non-real-time side.

use std::mem::size_of;

use shm_schemas::service as at;
use shm_schemas::{
    AgentSensors, ArenaTruth, BaseCommand, BaseState, GraspTarget, HandFrame, JointCommand,
    JointState, ModuleEvent, Payload, RunHeader, SensorStatus, Status, TickInputs, TickReport,
    View, WheelCommands, WorldTruth,
};

/// Settings of one publish-subscribe service.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Stream {
    /// Service name.
    pub service: &'static str,
    /// Type name of its payload.
    pub payload: &'static str,
    /// Capacity of a reader's buffer, payloads; the oldest are lost on overflow.
    pub buffer: usize,
    /// Number of past payloads delivered to a reader that joins.
    pub history: usize,
    /// Maximum number of writers.
    pub publishers: usize,
    /// Maximum number of readers.
    pub subscribers: usize,
    /// Size of one payload, bytes.
    pub payload_bytes: usize,
}

/// Maximum number of samples that a reader borrows at once.
pub const BORROWED_MAX: usize = 2;
/// Nodes beyond the peers, because a dead node keeps its slot until a clean-up. Design choice.
const SPARE_NODES: usize = 4;
/// iceoryx2's header of each payload, bytes, rounded up.
const HEADER_BYTES: usize = 128;

const fn stream<T: Payload>(
    service: &'static str,
    [buffer, history]: [usize; 2],
    [publishers, subscribers]: [usize; 2],
) -> Stream {
    let payload = T::TYPE_NAME;
    Stream {
        service,
        payload,
        buffer,
        history,
        publishers,
        subscribers,
        payload_bytes: size_of::<T>(),
    }
}

/// All streams: service, `[buffer, history]`, `[publishers, subscribers]`.
///
/// Buffers:
/// * frames 128: at 1 kHz, a reader that is not scheduled for an eighth of a second still gets every
///   frame; every reader locks the memory of all buffers (3.2 MB for both hands)
/// * commands 4: an old command is useless
/// * targets 16, without history: a later reader cannot use them
/// * reports 256: for readers that wake a few times per second
/// * events 1024, with history: a reader that joins after a task gets all its events
/// * recorded inputs 288: one recorder polls every millisecond, and a replay needs every input
pub const STREAMS: [Stream; 18] = [
    stream::<HandFrame>(at::HAND_FRAME[0], [128, 1], [1, 4]),
    stream::<HandFrame>(at::HAND_FRAME[1], [128, 1], [1, 4]),
    stream::<JointState>(at::JOINT_STATE, [16, 1], [1, 4]),
    stream::<JointCommand>(at::JOINT_COMMAND, [4, 1], [1, 4]),
    stream::<GraspTarget>(at::GRASP_TARGET, [16, 0], [1, 4]),
    stream::<Status>(at::STATUS, [2, 1], [1, 16]),
    stream::<TickReport>(at::TICK_REPORT, [256, 1], [1, 8]),
    stream::<View>(at::VIEW, [2, 1], [1, 16]),
    stream::<ModuleEvent>(at::MODULE_EVENT, [1024, 1024], [1, 8]),
    stream::<RunHeader>(at::RUN_HEADER, [1, 1], [1, 4]),
    stream::<TickInputs>(at::TICK_INPUTS, [288, 0], [1, 1]),
    stream::<SensorStatus>(at::SENSOR_STATUS, [4, 1], [8, 16]),
    stream::<WorldTruth>(at::WORLD_TRUTH, [4, 1], [1, 8]),
    stream::<AgentSensors>(at::AGENT_SENSORS, [4, 1], [1, 4]),
    stream::<WheelCommands>(at::WHEEL_COMMANDS, [4, 1], [1, 4]),
    stream::<BaseState>(at::BASE_STATE, [4, 1], [1, 4]),
    stream::<BaseCommand>(at::BASE_COMMAND, [4, 1], [1, 4]),
    stream::<ArenaTruth>(at::ARENA_TRUTH, [2, 1], [1, 8]),
];

impl Stream {
    pub(crate) fn find<T: Payload>(service: &str) -> Option<&'static Self> {
        STREAMS
            .iter()
            .find(|line| line.service == service && line.payload == T::TYPE_NAME)
    }

    /// Maximum number of processes that have the service open.
    #[must_use]
    pub const fn nodes(&self) -> usize {
        self.publishers + self.subscribers + SPARE_NODES
    }

    /// Shared memory of one publisher, bytes: all samples that can be queued, borrowed, kept as
    /// history or being written.
    pub(crate) fn publisher_bytes(&self) -> usize {
        let samples = self.subscribers * (self.buffer + BORROWED_MAX) + self.history + 1;
        samples * (self.payload_bytes + HEADER_BYTES)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn table_is_consistent() {
        for (i, line) in STREAMS.iter().enumerate() {
            assert!(line.history <= line.buffer, "{line:?}");
            assert!(line.publishers >= 1 && line.subscribers >= 1, "{line:?}");
            assert!(
                STREAMS[..i]
                    .iter()
                    .all(|other| other.service != line.service),
                "{line:?} is in the table twice"
            );
            assert!(
                line.publisher_bytes() < 8 << 20,
                "{line:?} takes {} bytes",
                line.publisher_bytes()
            );
        }
    }

    #[test]
    fn stream_is_found_by_service_and_payload() {
        assert!(Stream::find::<HandFrame>(at::HAND_FRAME[0]).is_some());
        assert!(Stream::find::<Status>(at::HAND_FRAME[0]).is_none());
        assert!(Stream::find::<HandFrame>("atas/v1/other").is_none());
    }

    #[test]
    fn motion_streams_have_one_writer() {
        for service in [
            at::HAND_FRAME[0],
            at::HAND_FRAME[1],
            at::JOINT_STATE,
            at::JOINT_COMMAND,
            at::GRASP_TARGET,
            at::BASE_STATE,
            at::BASE_COMMAND,
        ] {
            let line = STREAMS
                .iter()
                .find(|line| line.service == service)
                .expect("in the table");
            assert_eq!((line.publishers, line.subscribers), (1, 4), "{service}");
        }
    }
}
