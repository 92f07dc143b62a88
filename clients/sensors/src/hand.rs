//! Assembly of one hand's frames from its devices: readings become [`HandFrame`]s, health becomes
//! [`shm_schemas::SensorStatus`].
//!
//! * **Inputs:** readings per device. **Outputs:** one frame per reading of the pacing device, one
//!   status per device. A hand has a single publisher.
//! * The fastest device (the first of equals) paces the frames; each frame holds the others' newest
//!   values. If the pacing device is stale, the next to deliver replaces it until a faster one
//!   delivers.
//! * A fingertip is invalid if its device delivers nothing for three periods plus [`GRACE`], or
//!   fails. An overloaded taxel stays valid, as a lower bound. Layout elements beyond a smaller
//!   sensor are zero and valid.
//! * Readings that are not the newest are counted but not published. Sequence numbers only
//!   increase, with the gaps of the pacing device.

use std::time::Duration;

use shm_bus::BusName;
use shm_schemas::capacity::{ELEMENTS, FINGERS};
use shm_schemas::{Hand, HandFrame, Layout, Stamp};

use crate::failure::Failure;
use crate::newtons::Newtons;
use crate::reading::{Batch, Condition, Health, Output, Reading, Shape};
use crate::writer::{BURST, BURST_PAUSE, HandWriter};

/// Delay beyond three periods that makes fingertips invalid. Design choice: a USB bridge buffers
/// for up to 16 ms, a busy computer delays equally long.
pub const GRACE: Duration = Duration::from_millis(50);
/// Destination of a hand's frames.
#[derive(Clone, Debug, PartialEq)]
pub struct Destination {
    /// Name of the bus.
    pub bus: BusName,
    /// Published hand.
    pub hand: Hand,
    /// Layout of its fingertips.
    pub layout: Layout,
}

/// Fingertips and force conversion of a device.
#[derive(Clone, Debug, PartialEq)]
pub struct DeviceSlot {
    /// Driver name.
    pub driver: &'static str,
    /// Path or address.
    pub device: String,
    /// Index of its first fingertip.
    pub finger: usize,
    /// Content of its frames.
    pub shape: Shape,
    /// Conversion to newtons.
    pub newtons: Newtons,
    /// Nominal period, ns.
    pub period_ns: u64,
}

impl DeviceSlot {
    fn fingers(&self) -> core::ops::Range<usize> {
        self.finger..self.finger + self.shape.fingers
    }

    /// Returns the age limit of its newest reading, ns.
    fn stale_ns(&self) -> u64 {
        let grace_ns = u64::try_from(GRACE.as_nanos()).unwrap_or(u64::MAX);
        self.period_ns.saturating_mul(3).saturating_add(grace_ns)
    }
}

/// Fingertips of a device.
#[derive(Clone, Copy, Debug)]
pub struct FingertipRange<'a> {
    /// Path or address.
    pub device: &'a str,
    /// Index of its first fingertip.
    pub finger: usize,
    /// Number of fingertips.
    pub fingers: usize,
}

/// Returns the first conflict between a hand's devices: index out of range, or overlap.
#[must_use]
pub fn find_conflict(spans: &[FingertipRange<'_>]) -> Option<String> {
    for (n, span) in spans.iter().enumerate() {
        let end = span.finger + span.fingers;
        if end > FINGERS {
            return Some(format!(
                "could not place {} channels from --finger {}: a hand has {FINGERS} fingertips; \
                 use --finger 0",
                span.fingers, span.finger
            ));
        }
        let overlaps = |other: &&FingertipRange<'_>| {
            span.finger < other.finger + other.fingers && other.finger < end
        };
        if let Some(other) = spans[..n].iter().find(overlaps) {
            return Some(format!(
                "could not place {} and {} on the same fingertip; give each its own --finger",
                other.device, span.device
            ));
        }
    }
    None
}

/// Combines readings, without a bus.
#[derive(Debug)]
pub struct FrameAssembler {
    slots: Vec<DeviceSlot>,
    /// Capture time of each device's newest reading, ns.
    last_ns: Vec<Option<u64>>,
    pacing_port: usize,
    next_sequence: u64,
    /// Bit mask of the layout's elements.
    elements: u64,
    frame: HandFrame,
}

impl FrameAssembler {
    /// Creates the assembler of one hand.
    #[must_use]
    pub fn new(slots: Vec<DeviceSlot>, hand: Hand, layout: &Layout, stamp: Stamp) -> Self {
        let end = slots.iter().map(|seat| seat.fingers().end).max();
        Self {
            last_ns: vec![None; slots.len()],
            pacing_port: 0,
            next_sequence: 0,
            elements: u64::MAX >> (64 - layout.count.clamp(1, 64)),
            frame: HandFrame {
                stamp,
                layout_hash: layout.hash(),
                hand,
                finger_count: end.unwrap_or(0) as u32,
                ..HandFrame::default()
            },
            slots,
        }
    }

    /// Accepts a reading of device `port`; returns a frame if that device is pacing.
    pub fn update(&mut self, port: usize, reading: &Reading, values: &[f64]) -> Option<&HandFrame> {
        if reading.advance == 0 {
            return None;
        }
        self.write(port, reading, values);
        self.last_ns[port] = Some(reading.captured_ns);
        if self.is_faster(port, self.pacing_port)
            || self.is_stale(self.pacing_port, reading.captured_ns)
        {
            self.pacing_port = port;
        }
        if port != self.pacing_port {
            return None;
        }
        self.mark_stale(reading.captured_ns);
        self.next_sequence += reading.advance;
        let stamp = &mut self.frame.stamp;
        stamp.sequence = self.next_sequence - 1;
        // Capture times increase even if the pacing device changes.
        stamp.captured_ns = reading.captured_ns.max(stamp.captured_ns + 1);
        self.frame.seal();
        Some(&self.frame)
    }

    fn write(&mut self, port: usize, reading: &Reading, values: &[f64]) {
        let seat = &self.slots[port];
        let quantity = seat.shape.quantity;
        let group = quantity.axes().len();
        for (tip, (finger, values)) in seat
            .fingers()
            .zip(values.chunks_exact(group * seat.shape.taxels))
            .enumerate()
        {
            let mut mask = self.elements;
            let mut forces_n = [[0.0; 3]; ELEMENTS];
            let count = seat.newtons.write(tip, quantity, values, &mut forces_n);
            for (element, force_n) in forces_n.into_iter().enumerate().take(count) {
                let is_finite = force_n.iter().all(|f| f.is_finite());
                self.frame.force_n[finger][element] = if is_finite { force_n } else { [0.0; 3] };
                mask &= !(u64::from(!is_finite) << element);
            }
            let is_believed = reading.condition != Condition::Failed;
            self.frame.valid_mask[finger] = if is_believed { mask } else { 0 };
        }
    }

    fn is_faster(&self, port: usize, other: usize) -> bool {
        (self.slots[port].period_ns, port) < (self.slots[other].period_ns, other)
    }

    fn is_stale(&self, port: usize, now_ns: u64) -> bool {
        let limit_ns = self.slots[port].stale_ns();
        self.last_ns[port].is_none_or(|last_ns| now_ns.saturating_sub(last_ns) > limit_ns)
    }

    fn mark_stale(&mut self, now_ns: u64) {
        for port in 0..self.slots.len() {
            if self.is_stale(port, now_ns) {
                self.frame.valid_mask[self.slots[port].fingers()].fill(0);
            }
        }
    }
}

/// Publisher of one hand's frames and statuses.
#[derive(Debug)]
pub struct HandOutput {
    writer: HandWriter,
    assembly: FrameAssembler,
}

impl HandOutput {
    /// Joins the bus and claims the hand's frame service.
    ///
    /// # Errors
    /// [`Failure::Bus`] if the bus cannot be joined or another process publishes for this hand.
    pub fn open(place: &Destination, slots: Vec<DeviceSlot>) -> Result<Self, Failure> {
        let devices = slots.iter().map(|seat| (seat.driver, &*seat.device));
        let writer = HandWriter::open(&place.bus, place.hand, devices)?;
        let stamp = Stamp {
            writer_epoch: writer.epoch(),
            ..Stamp::default()
        };
        Ok(Self {
            writer,
            assembly: FrameAssembler::new(slots, place.hand, &place.layout, stamp),
        })
    }

    /// Accepts a device's readings.
    ///
    /// # Errors
    /// [`Failure::Bus`] if the bus has failed.
    pub fn readings(&mut self, port: usize, batch: &Batch) -> Result<(), Failure> {
        for (n, (reading, values)) in batch.iter().enumerate() {
            if n > 0 && n.is_multiple_of(BURST) {
                std::thread::sleep(BURST_PAUSE);
            }
            if let Some(frame) = self.assembly.update(port, reading, values) {
                self.writer.frame(frame)?;
            }
        }
        Ok(())
    }

    /// Accepts a device's health report.
    ///
    /// # Errors
    /// [`Failure::Bus`] if the bus has failed.
    pub fn health(&mut self, port: usize, health: &Health) -> Result<(), Failure> {
        self.writer.health(port, health)
    }
}

impl Output for HandOutput {
    fn readings(&mut self, batch: &Batch) -> Result<(), Failure> {
        self.readings(0, batch)
    }

    fn health(&mut self, health: &Health) -> Result<(), Failure> {
        self.health(0, health)
    }
}
