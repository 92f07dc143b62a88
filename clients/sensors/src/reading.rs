//! What every driver says, whatever its device: shapes, frames, counts.
//!
//! A [`Frame`] holds the device's own units; [`crate::mapping`] makes newtons of them. Nothing here knows a wire format,
//! a transport or the bus.

use core::fmt;

use crate::continuity::{Arrival, Totals};

/// What one value group of a frame means.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// Force along x, y, z per taxel.
    Force,
    /// Force and torque along x, y, z: one six-axis sensor.
    Wrench,
    /// Pressure per taxel: a normal force without tangential ones.
    Pressure,
    /// Magnetic flux density along x, y, z per taxel; a calibration makes forces of it.
    Flux,
}

impl Quantity {
    /// Names of the values of one taxel, in order.
    #[must_use]
    pub const fn axes(self) -> &'static [&'static str] {
        match self {
            Self::Force => &["fx", "fy", "fz"],
            Self::Wrench => &["fx", "fy", "fz", "tx", "ty", "tz"],
            Self::Pressure => &["p"],
            Self::Flux => &["bx", "by", "bz"],
        }
    }

    /// Whether what measures it says how warm it is.
    #[must_use]
    pub const fn has_temperature(self) -> bool {
        matches!(self, Self::Flux)
    }

    /// Force-like x, y, z of one taxel's values. A pressure is a load along z; torques are left out.
    #[must_use]
    pub fn vector(self, taxel: &[f64]) -> [f64; 3] {
        match (self, taxel) {
            (Self::Pressure, [p, ..]) => [0.0, 0.0, *p],
            (_, [x, y, z, ..]) => [*x, *y, *z],
            _ => [f64::NAN; 3],
        }
    }
}

/// What one frame of a device holds: `fingers × taxels` groups of [`Quantity::axes`] values.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shape {
    /// What is measured.
    pub quantity: Quantity,
    /// The device's own unit, as it stands in column names: `counts`, `n`, `ut`.
    pub unit: &'static str,
    /// Fingertips that one device covers.
    pub fingers: usize,
    /// Taxels of one fingertip.
    pub taxels: usize,
}

impl Shape {
    /// Values of one frame.
    #[must_use]
    pub const fn values(self) -> usize {
        self.fingers * self.taxels * self.quantity.axes().len()
    }
}

/// What a device says of itself with a frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Condition {
    /// Nothing is wrong.
    #[default]
    Well,
    /// A warning or an overload: the values still say something, if only "very large".
    Strained,
    /// The values mean nothing.
    Failed,
}

/// One valid frame of a device, in the device's own units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame<'a> {
    /// Offset of its first byte from the beginning of the stream.
    pub byte_offset: u64,
    /// The device's own frame counter, where it has one.
    pub count: Option<u32>,
    /// The device's status word, 0 where it has none.
    pub status: u32,
    /// How warm the sensor is, °C, where it says so.
    pub temperature_c: Option<f64>,
    /// What that word amounts to.
    pub condition: Condition,
    /// As many values as [`Shape::values`] says, finger by finger, taxel by taxel.
    pub values: &'a [f64],
}

/// Where the bytes of a stream went: `received = data + acknowledgement + junk + pending`, always.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ByteCounts {
    /// Bytes given to the decoder.
    pub received: u64,
    /// Bytes of valid data frames.
    pub data: u64,
    /// Bytes of valid acknowledgements and other messages that carry no reading.
    pub acknowledgement: u64,
    /// Bytes that belong to no valid message.
    pub junk: u64,
    /// Bytes that may still become a message; 0 at the end of the stream.
    pub pending: u64,
    /// Valid data frames.
    pub frames: u64,
    /// Valid acknowledgements and other messages that carry no reading.
    pub acknowledgements: u64,
    /// Messages that were recognised, but whose checksum, length or content does not hold.
    pub checksum_failures: u64,
}

/// Everything counted so far about one device.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Health {
    /// Where the bytes went.
    pub bytes: ByteCounts,
    /// What the counts of the frames say.
    pub continuity: Totals,
    /// Frames whose status reports an error or an overload.
    pub device_errors: u64,
    /// Status word of the newest frame.
    pub device_status: u32,
    /// Whether data came lately, see [`crate::port::SILENCE`].
    pub alive: bool,
}

impl Health {
    /// Whether something was lost or damaged between two reports.
    #[must_use]
    pub fn is_worse_than(&self, before: &Self) -> bool {
        before.bytes.junk < self.bytes.junk
            || before.continuity != self.continuity
            || before.device_errors < self.device_errors
    }
}

impl fmt::Display for Health {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            bytes, continuity, ..
        } = self;
        write!(
            f,
            "{} frames, {} lost, {} duplicates, {} late, {} restarts, {} stray counts; {} bytes, {} junk, \
             {} checksum failures; {} device errors",
            bytes.frames,
            continuity.lost,
            continuity.duplicates,
            continuity.late,
            continuity.restarts,
            continuity.strays,
            bytes.received,
            bytes.junk,
            bytes.checksum_failures,
            self.device_errors,
        )
    }
}

/// One frame and what is known about it; its values stand in the [`Batch`].
#[derive(Clone, Copy, Debug)]
pub struct Reading {
    /// Offset of its first byte from the beginning of the stream.
    pub byte_offset: u64,
    /// The device's own frame counter, where it has one.
    pub count: Option<u32>,
    /// The device's status word.
    pub status: u32,
    /// How warm the sensor is, °C, where it says so.
    pub temperature_c: Option<f64>,
    /// What that word amounts to.
    pub condition: Condition,
    /// How it relates to the frames before it.
    pub arrival: Arrival,
    /// By how much it advances a numbering that has the device's gaps; 0 for frames that are not newer than all before.
    pub advance: u64,
    /// When it was true, ns of `CLOCK_MONOTONIC`; an estimate, see [`crate::stamping`].
    pub captured_ns: u64,
}

/// The readings of one read from a device, in order of arrival. Keeps its memory from batch to batch.
#[derive(Clone, Debug, Default)]
pub struct Batch {
    width: usize,
    /// The readings.
    pub readings: Vec<Reading>,
    values: Vec<f64>,
}

impl Batch {
    /// For frames of this shape.
    #[must_use]
    pub fn new(shape: Shape) -> Self {
        Self {
            width: shape.values(),
            ..Self::default()
        }
    }

    /// Adds a reading. Values that do not fit the shape are refused, because all others would move.
    pub fn push(&mut self, reading: Reading, values: &[f64]) {
        if values.len() == self.width {
            self.readings.push(reading);
            self.values.extend_from_slice(values);
        }
    }

    /// Readings with their values.
    pub fn iter(&self) -> impl Iterator<Item = (&Reading, &[f64])> {
        self.readings
            .iter()
            .zip(self.values.chunks_exact(self.width.max(1)))
    }

    /// Number of readings.
    #[must_use]
    pub fn len(&self) -> usize {
        self.readings.len()
    }

    /// Whether there is none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.readings.is_empty()
    }

    /// Forgets all readings.
    pub fn clear(&mut self) {
        self.readings.clear();
        self.values.clear();
    }
}

/// A place for readings.
pub trait Output {
    /// Takes the readings of one read from the device, in order of arrival.
    ///
    /// # Errors
    /// When the place is gone.
    fn readings(&mut self, batch: &Batch) -> Result<(), crate::failure::Failure>;

    /// Takes a regular report, about ten times a second and once at the end.
    ///
    /// # Errors
    /// When the place is gone.
    fn health(&mut self, health: &Health) -> Result<(), crate::failure::Failure>;
}
