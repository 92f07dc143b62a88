//! What a process writes on the bus for one hand: its frames, and of each of its devices how it is.

use std::time::Duration;

use shm_bus::{Bus, BusName, Publisher, Realtime, now_ns, writer_epoch};
use shm_schemas::service::{HAND_FRAME, SENSOR_STATUS};
use shm_schemas::{Hand, HandFrame, SensorStatus, Stamp, Text};

use crate::failure::Failure;
use crate::reading::Health;

/// Frames published at once at most; a backlog is handed out in such portions, one per [`BURST_PAUSE`], so that a
/// reader on a 1 ms tick is never overrun (it buffers 64 frames). Ours.
pub const BURST: usize = 16;
/// Pause between two portions of a backlog: the tick of the daemon.
pub const BURST_PAUSE: Duration = Duration::from_millis(1);

/// The one writer of a hand.
#[derive(Debug)]
pub struct HandWriter {
    frames: Publisher<HandFrame>,
    statuses: Publisher<SensorStatus>,
    /// Per device.
    status: Vec<SensorStatus>,
    epoch: u64,
    next_status: u64,
}

impl HandWriter {
    /// Joins the bus and takes the hand's frame service. Each device has the name of its driver, and its path or address.
    ///
    /// # Errors
    /// [`Failure::Bus`] when the bus cannot be joined or another process feels for this hand.
    pub fn open<'a>(
        bus: &BusName,
        hand: Hand,
        devices: impl Iterator<Item = (&'a str, &'a str)>,
    ) -> Result<Self, Failure> {
        let epoch = writer_epoch();
        let node = Bus::open(bus, &format!("sensor-{hand}"), Realtime::No).map_err(Failure::Bus)?;
        let service = HAND_FRAME[usize::from(hand != Hand::LEFT)];
        let status = |(driver, device)| SensorStatus {
            stamp: Stamp {
                writer_epoch: epoch,
                ..Stamp::default()
            },
            driver: Text::new(driver),
            device: Text::new(device),
            hand,
            ..SensorStatus::default()
        };
        Ok(Self {
            frames: node.publisher(service).map_err(Failure::Bus)?,
            statuses: node.publisher(SENSOR_STATUS).map_err(Failure::Bus)?,
            status: devices.map(status).collect(),
            epoch,
            next_status: 0,
        })
    }

    /// What its frames' stamps must carry.
    #[must_use]
    pub fn epoch(&self) -> u64 {
        self.epoch
    }

    /// Publishes a frame that is stamped and sealed.
    ///
    /// # Errors
    /// [`Failure::Bus`] when the bus is gone.
    pub fn frame(&self, frame: &HandFrame) -> Result<(), Failure> {
        self.frames.send(frame).map_err(Failure::Bus)
    }

    /// Publishes one device's report.
    ///
    /// # Errors
    /// [`Failure::Bus`] when the bus is gone.
    pub fn health(&mut self, device: usize, health: &Health) -> Result<(), Failure> {
        let status = &mut self.status[device];
        status.stamp.captured_ns = now_ns();
        status.stamp.sequence = self.next_status;
        status.alive = u32::from(health.alive);
        status.frames = health.bytes.frames;
        status.lost = health.continuity.lost;
        status.junk_bytes = health.bytes.junk;
        status.checksum_failures = health.bytes.checksum_failures;
        status.device_errors = health.device_errors;
        status.device_status = health.device_status;
        self.statuses.send(status).map_err(Failure::Bus)?;
        self.next_status += 1;
        Ok(())
    }
}
