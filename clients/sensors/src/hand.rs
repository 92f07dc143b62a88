//! One hand's frames from one or more devices: readings as [`HandFrame`]s, health as [`shm_schemas::SensorStatus`].
//!
//! * **In:** readings of each device, as they come. **Out:** one frame per reading of the device that sets the pace, and
//!   one status per device, all from the one writer that a hand may have.
//! * The fastest device sets the pace (the first of equals); what the others read last stands beside it. When the pace
//!   maker is silent for longer than it may, the next fastest that delivers takes over, until it is back.
//! * A finger whose device has said nothing for three of its periods and [`GRACE`] is marked invalid, and so are
//!   values of a device that reports an error. An overloaded taxel stays valid: it still says "very large". Elements of
//!   the layout that a smaller sensor does not have feel nothing, which is valid.
//! * Readings that are not newer than all before are counted in the status but not published: the series on the bus only
//!   goes forward, and its gaps are those of the device that sets the pace.

use std::time::Duration;

use shm_bus::BusName;
use shm_schemas::capacity::{ELEMENTS, FINGERS};
use shm_schemas::{Hand, HandFrame, Layout, Stamp};

use crate::failure::Failure;
use crate::newtons::Newtons;
use crate::reading::{Batch, Condition, Health, Output, Reading, Shape};
use crate::writer::{BURST, BURST_PAUSE, HandWriter};

/// How much later than three periods a device's reading may come before its finger is invalid. Ours: a USB bridge
/// collects for up to 16 ms, and a busy machine delays a process by as much again.
pub const GRACE: Duration = Duration::from_millis(50);
/// Where a hand's frames go.
#[derive(Clone, Debug, PartialEq)]
pub struct Place {
    /// Name of the bus.
    pub bus: BusName,
    /// The hand.
    pub hand: Hand,
    /// The layout that its fingertips follow.
    pub layout: Layout,
}

/// Which part of the hand a device feels for, and how its values become newtons.
#[derive(Clone, Debug, PartialEq)]
pub struct Seat {
    /// Name of the driver.
    pub driver: &'static str,
    /// Path or address of the device.
    pub device: String,
    /// The finger of the device's first fingertip.
    pub finger: usize,
    /// What its frames hold.
    pub shape: Shape,
    /// From its units to newtons.
    pub newtons: Newtons,
    /// Its nominal period, ns.
    pub period_ns: u64,
}

impl Seat {
    /// The fingers that it covers.
    fn fingers(&self) -> core::ops::Range<usize> {
        self.finger..self.finger + self.shape.fingers
    }

    /// Age at which its reading is no longer believed, ns.
    fn stale_ns(&self) -> u64 {
        let grace_ns = u64::try_from(GRACE.as_nanos()).unwrap_or(u64::MAX);
        self.period_ns.saturating_mul(3).saturating_add(grace_ns)
    }
}

/// The fingers that a device covers.
#[derive(Clone, Copy, Debug)]
pub struct Span<'a> {
    /// Path or address of the device.
    pub device: &'a str,
    /// The finger of its first fingertip.
    pub finger: usize,
    /// Its fingertips.
    pub fingers: usize,
}

/// What is wrong with a set of devices on one hand, if anything.
#[must_use]
pub fn conflict(spans: &[Span<'_>]) -> Option<String> {
    for (n, span) in spans.iter().enumerate() {
        let end = span.finger + span.fingers;
        if end > FINGERS {
            return Some(format!(
                "could not place {} channels from --finger {}: a hand has {FINGERS} fingers; use --finger 0",
                span.fingers, span.finger
            ));
        }
        let overlaps =
            |other: &&Span<'_>| span.finger < other.finger + other.fingers && other.finger < end;
        if let Some(other) = spans[..n].iter().find(overlaps) {
            return Some(format!(
                "could not place {} and {} on the same finger; give each its own --finger",
                other.device, span.device
            ));
        }
    }
    None
}

/// Puts readings together, without a bus.
#[derive(Debug)]
pub struct Assembly {
    seats: Vec<Seat>,
    /// When each device last delivered, ns; `None` before its first reading.
    last_ns: Vec<Option<u64>>,
    pace: usize,
    next_sequence: u64,
    /// Elements of the layout, as a mask.
    elements: u64,
    frame: HandFrame,
}

impl Assembly {
    /// For the devices of one hand.
    #[must_use]
    pub fn new(seats: Vec<Seat>, hand: Hand, layout: &Layout, stamp: Stamp) -> Self {
        let end = seats.iter().map(|seat| seat.fingers().end).max();
        Self {
            last_ns: vec![None; seats.len()],
            pace: 0,
            next_sequence: 0,
            elements: u64::MAX >> (64 - layout.count.clamp(1, 64)),
            frame: HandFrame {
                stamp,
                layout_hash: layout.hash(),
                hand,
                finger_count: end.unwrap_or(0) as u32,
                ..HandFrame::default()
            },
            seats,
        }
    }

    /// Takes a reading of device `port`; returns the hand's next frame when that device sets the pace.
    pub fn take(&mut self, port: usize, reading: &Reading, values: &[f64]) -> Option<&HandFrame> {
        if reading.advance == 0 {
            return None;
        }
        self.write(port, reading, values);
        self.last_ns[port] = Some(reading.captured_ns);
        if self.outranks(port, self.pace) || self.is_stale(self.pace, reading.captured_ns) {
            self.pace = port;
        }
        if port != self.pace {
            return None;
        }
        self.mark_stale(reading.captured_ns);
        self.next_sequence += reading.advance;
        let stamp = &mut self.frame.stamp;
        stamp.sequence = self.next_sequence - 1;
        // A change of pace maker must not turn time back.
        stamp.captured_ns = reading.captured_ns.max(stamp.captured_ns + 1);
        self.frame.seal();
        Some(&self.frame)
    }

    fn write(&mut self, port: usize, reading: &Reading, values: &[f64]) {
        let seat = &self.seats[port];
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

    fn outranks(&self, port: usize, other: usize) -> bool {
        (self.seats[port].period_ns, port) < (self.seats[other].period_ns, other)
    }

    fn is_stale(&self, port: usize, now_ns: u64) -> bool {
        let limit_ns = self.seats[port].stale_ns();
        self.last_ns[port].is_none_or(|last_ns| now_ns.saturating_sub(last_ns) > limit_ns)
    }

    fn mark_stale(&mut self, now_ns: u64) {
        for port in 0..self.seats.len() {
            if self.is_stale(port, now_ns) {
                self.frame.valid_mask[self.seats[port].fingers()].fill(0);
            }
        }
    }
}

/// Publishes for one hand.
#[derive(Debug)]
pub struct HandOutput {
    writer: HandWriter,
    assembly: Assembly,
}

impl HandOutput {
    /// Joins the bus and takes the hand's frame service, of which there is one writer.
    ///
    /// # Errors
    /// [`Failure::Bus`] when the bus cannot be joined or another process feels for this hand.
    pub fn open(place: &Place, seats: Vec<Seat>) -> Result<Self, Failure> {
        let devices = seats.iter().map(|seat| (seat.driver, &*seat.device));
        let writer = HandWriter::open(&place.bus, place.hand, devices)?;
        let stamp = Stamp {
            writer_epoch: writer.epoch(),
            ..Stamp::default()
        };
        Ok(Self {
            writer,
            assembly: Assembly::new(seats, place.hand, &place.layout, stamp),
        })
    }

    /// Takes one device's readings.
    ///
    /// # Errors
    /// [`Failure::Bus`] when the bus is gone.
    pub fn readings(&mut self, port: usize, batch: &Batch) -> Result<(), Failure> {
        for (n, (reading, values)) in batch.iter().enumerate() {
            if n > 0 && n.is_multiple_of(BURST) {
                std::thread::sleep(BURST_PAUSE);
            }
            if let Some(frame) = self.assembly.take(port, reading, values) {
                self.writer.frame(frame)?;
            }
        }
        Ok(())
    }

    /// Takes one device's report.
    ///
    /// # Errors
    /// [`Failure::Bus`] when the bus is gone.
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
