//! Readings as [`HandFrame`]s of one hand, health as [`SensorStatus`].
//!
//! Frames that are not newer than all before (duplicates, late ones) are counted in the status but not published:
//! the series on the bus only goes forward, and its gaps are the device's. An element is marked invalid while the device
//! reports an error; an overloaded element stays valid, because its saturated reading still says "very large".

use std::time::Duration;

use shm_bus::{Bus as Node, BusError, Publisher, Realtime, now_ns, writer_epoch};
use shm_schemas::service::{HAND_FRAME, SENSOR_STATUS};
use shm_schemas::{Hand, HandFrame, Layout, SensorStatus, Stamp, Text};

use super::{Health, Output, Reading};
use crate::cli::Place;
use crate::failure::Failure;
use crate::wire::optoforce::Kind;

/// Frames published at once at most; a backlog is handed out in such portions, one per [`BURST_PAUSE`], so that a
/// reader on a 1 ms tick is never overrun (it buffers 64 frames). Ours.
const BURST: usize = 16;
/// Pause between two portions of a backlog: the tick of the daemon.
const BURST_PAUSE: Duration = Duration::from_millis(1);

/// Publishes for one hand.
#[derive(Debug)]
pub struct Bus {
    frames: Publisher<HandFrame>,
    statuses: Publisher<SensorStatus>,
    place: Place,
    /// Everything that stays the same from frame to frame.
    frame: HandFrame,
    status: SensorStatus,
}

impl Bus {
    /// Joins the bus and takes the hand's frame service, of which there is one writer.
    ///
    /// # Errors
    /// [`Failure::Bus`] when the bus cannot be joined or another process feels for this hand.
    pub fn open(place: Place, kind: Kind, device: &str) -> Result<Self, Failure> {
        let stamp = Stamp {
            writer_epoch: writer_epoch(),
            ..Stamp::default()
        };
        let hand = place.hand;
        let node =
            Node::open(&place.bus, &format!("sensor-{hand}"), Realtime::No).map_err(bus_failure)?;
        let service = if hand == Hand::LEFT {
            HAND_FRAME[0]
        } else {
            HAND_FRAME[1]
        };
        Ok(Self {
            frames: node.publisher(service).map_err(bus_failure)?,
            statuses: node.publisher(SENSOR_STATUS).map_err(bus_failure)?,
            frame: HandFrame {
                stamp,
                layout_hash: Layout::named("dome-1").map_or(0, |layout| layout.hash()),
                hand,
                finger_count: (place.finger + kind.channel_count()) as u32,
                ..HandFrame::default()
            },
            status: SensorStatus {
                stamp,
                driver: Text::new("optoforce"),
                device: Text::new(device),
                hand,
                ..SensorStatus::default()
            },
            place,
        })
    }

    fn publish(&mut self, reading: &Reading) -> Result<(), Failure> {
        let frame = &mut self.frame;
        frame.stamp.sequence = reading.sequence;
        frame.stamp.captured_ns = reading.captured_ns;
        let valid = u64::from(!reading.frame.status.is_failed());
        for (channel, counts) in reading.frame.forces().enumerate() {
            let finger = self.place.finger + channel;
            frame.valid_mask[finger] = valid;
            frame.force_n[finger][0] = self.place.mapping.force_n(counts);
        }
        frame.seal();
        self.frames.send(frame).map_err(bus_failure)
    }
}

impl Output for Bus {
    fn readings(&mut self, readings: &[Reading]) -> Result<(), Failure> {
        for portion in readings.chunks(BURST) {
            for reading in portion
                .iter()
                .filter(|reading| reading.arrival.advance().is_some())
            {
                self.publish(reading)?;
            }
            if readings.len() > BURST {
                std::thread::sleep(BURST_PAUSE);
            }
        }
        Ok(())
    }

    fn health(&mut self, health: &Health) -> Result<(), Failure> {
        let status = &mut self.status;
        status.stamp.captured_ns = now_ns();
        status.alive = u32::from(health.alive);
        status.frames = health.bytes.frames;
        status.lost = health.continuity.lost;
        status.junk_bytes = health.bytes.junk;
        status.checksum_failures = health.bytes.checksum_failures;
        status.device_errors = health.device_errors;
        status.device_status = u32::from(health.device_status.0);
        self.statuses.send(status).map_err(bus_failure)?;
        status.stamp.sequence += 1;
        Ok(())
    }
}

fn bus_failure(error: BusError) -> Failure {
    Failure::Bus(error)
}
