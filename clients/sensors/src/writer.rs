//! Bus publisher of one hand: its frames, and the health of each device.

use std::time::Duration;

use shm_bus::{Bus, BusName, Publisher, Realtime, now_ns, writer_epoch};
use shm_schemas::service::{HAND_FRAME, SENSOR_STATUS};
use shm_schemas::{Hand, HandFrame, SensorStatus, Stamp, Text};

use crate::failure::Failure;
use crate::reading::Health;

/// Maximum frames published at once; a backlog is split with [`BURST_PAUSE`] in between. Design
/// choice: a reader with a 1 ms tick buffers 64 frames and must not overrun.
pub const BURST: usize = 16;
/// Pause between portions of a backlog: the daemon's tick.
pub const BURST_PAUSE: Duration = Duration::from_millis(1);

/// Only publisher of a hand's frames.
#[derive(Debug)]
pub struct HandWriter {
    frames: Publisher<HandFrame>,
    statuses: Publisher<SensorStatus>,
    status: Vec<SensorStatus>,
    epoch: u64,
    next_status: u64,
}

impl HandWriter {
    /// Joins the bus and claims the hand's frame service. `devices` yields driver name and path or
    /// address.
    ///
    /// # Errors
    /// [`Failure::Bus`] if the bus cannot be joined or another process publishes for this hand.
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

    /// Returns the writer epoch for frame stamps.
    #[must_use]
    pub fn epoch(&self) -> u64 {
        self.epoch
    }

    /// Publishes a stamped and sealed frame.
    ///
    /// # Errors
    /// [`Failure::Bus`] if the bus has failed.
    pub fn frame(&self, frame: &HandFrame) -> Result<(), Failure> {
        self.frames.send(frame).map_err(Failure::Bus)
    }

    /// Publishes a device's health report.
    ///
    /// # Errors
    /// [`Failure::Bus`] if the bus has failed.
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
