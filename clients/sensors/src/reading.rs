//! Data types common to all drivers: shapes, frames, readings and counts.
//!
//! Values are in device units; [`crate::mapping`] converts them to newtons. Independent of wire
//! formats, transports and the bus.

use core::fmt;

use crate::continuity::{Arrival, Totals};

/// Physical quantity of a value group.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// Force x, y, z per taxel.
    Force,
    /// Force and torque x, y, z of a six-axis sensor.
    Wrench,
    /// Pressure per taxel (normal force only).
    Pressure,
    /// Magnetic flux density x, y, z per taxel; needs a calibration.
    Flux,
}

impl Quantity {
    /// Returns the value names of one taxel.
    #[must_use]
    pub const fn axes(self) -> &'static [&'static str] {
        match self {
            Self::Force => &["fx", "fy", "fz"],
            Self::Wrench => &["fx", "fy", "fz", "tx", "ty", "tz"],
            Self::Pressure => &["p"],
            Self::Flux => &["bx", "by", "bz"],
        }
    }

    /// Returns whether such sensors report temperature.
    #[must_use]
    pub const fn has_temperature(self) -> bool {
        matches!(self, Self::Flux)
    }

    /// Returns x, y, z of one taxel; pressure becomes z, torques are dropped.
    #[must_use]
    pub fn vector(self, taxel: &[f64]) -> [f64; 3] {
        match (self, taxel) {
            (Self::Pressure, [p, ..]) => [0.0, 0.0, *p],
            (_, [x, y, z, ..]) => [*x, *y, *z],
            _ => [f64::NAN; 3],
        }
    }
}

/// Content of one device frame: `fingers × taxels` groups of [`Quantity::axes`] values.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shape {
    /// Measured quantity.
    pub quantity: Quantity,
    /// Device unit in column names: `counts`, `n`, `ut`.
    pub unit: &'static str,
    /// Fingertips per device.
    pub fingers: usize,
    /// Taxels per fingertip.
    pub taxels: usize,
}

impl Shape {
    /// Returns the value count per frame.
    #[must_use]
    pub const fn values(self) -> usize {
        self.fingers * self.taxels * self.quantity.axes().len()
    }
}

/// Device condition reported with a frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Condition {
    /// No fault.
    #[default]
    Normal,
    /// Warning or overload: the values are a lower bound ("very large").
    Degraded,
    /// The values are invalid.
    Failed,
}

/// One valid frame of a device, in device units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame<'a> {
    /// Stream offset of its first byte.
    pub byte_offset: u64,
    /// Device frame counter, if any.
    pub count: Option<u32>,
    /// Device status word; 0 if it has none.
    pub status: u32,
    /// Sensor temperature, °C, if reported.
    pub temperature_c: Option<f64>,
    /// Condition decoded from the status word.
    pub condition: Condition,
    /// [`Shape::values`] values, ordered by fingertip, then taxel.
    pub values: &'a [f64],
}

/// Classification of a stream's bytes; always `received = data + acknowledgement + junk + pending`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ByteCounts {
    /// Bytes received.
    pub received: u64,
    /// Bytes of valid data frames.
    pub data: u64,
    /// Bytes of valid messages without a reading, such as acknowledgements.
    pub acknowledgement: u64,
    /// Bytes outside valid messages.
    pub junk: u64,
    /// Bytes of a possibly incomplete message; 0 at the end of the stream.
    pub pending: u64,
    /// Valid data frames.
    pub frames: u64,
    /// Valid messages without a reading.
    pub acknowledgements: u64,
    /// Recognised messages with an invalid checksum, length or content.
    pub checksum_failures: u64,
}

/// Counts of one device.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Health {
    /// Byte and message counts.
    pub bytes: ByteCounts,
    /// Counts from the device's frame counter.
    pub continuity: Totals,
    /// Frames that report an error or overload.
    pub device_errors: u64,
    /// Newest status word.
    pub device_status: u32,
    /// True if data arrived within [`crate::port::ALIVE_TIMEOUT`].
    pub alive: bool,
}

impl Health {
    /// Returns whether data were lost or damaged since `before`.
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

/// Metadata of one frame; the [`Batch`] stores its values.
#[derive(Clone, Copy, Debug)]
pub struct Reading {
    /// Stream offset of its first byte.
    pub byte_offset: u64,
    /// Device frame counter, if any.
    pub count: Option<u32>,
    /// Device status word.
    pub status: u32,
    /// Sensor temperature, °C, if reported.
    pub temperature_c: Option<f64>,
    /// Condition decoded from the status word.
    pub condition: Condition,
    /// Relation to the preceding frames.
    pub arrival: Arrival,
    /// Sequence increment including the device's gaps; 0 if the frame is not the newest.
    pub advance: u64,
    /// Estimated capture time, ns of `CLOCK_MONOTONIC`; see [`crate::stamping`].
    pub captured_ns: u64,
}

/// Readings of one device read, in order of arrival; reuses its memory.
#[derive(Clone, Debug, Default)]
pub struct Batch {
    width: usize,
    /// Metadata.
    pub readings: Vec<Reading>,
    values: Vec<f64>,
}

impl Batch {
    /// Creates an empty batch.
    #[must_use]
    pub fn new(shape: Shape) -> Self {
        Self {
            width: shape.values(),
            ..Self::default()
        }
    }

    /// Appends a reading. Ignores values of another width, which would shift all later ones.
    pub fn push(&mut self, reading: Reading, values: &[f64]) {
        if values.len() == self.width {
            self.readings.push(reading);
            self.values.extend_from_slice(values);
        }
    }

    /// Iterates over the readings and their values.
    pub fn iter(&self) -> impl Iterator<Item = (&Reading, &[f64])> {
        self.readings
            .iter()
            .zip(self.values.chunks_exact(self.width.max(1)))
    }

    /// Returns the number of readings.
    #[must_use]
    pub fn len(&self) -> usize {
        self.readings.len()
    }

    /// Returns whether the batch is empty.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.readings.is_empty()
    }

    /// Removes all readings.
    pub fn clear(&mut self) {
        self.readings.clear();
        self.values.clear();
    }
}

/// Destination of readings and reports.
pub trait Output {
    /// Accepts readings in order of arrival.
    ///
    /// # Errors
    /// If the destination has failed.
    fn readings(&mut self, batch: &Batch) -> Result<(), crate::failure::Failure>;

    /// Accepts a health report, about ten times a second and at the end.
    ///
    /// # Errors
    /// If the destination has failed.
    fn health(&mut self, health: &Health) -> Result<(), crate::failure::Failure>;
}
