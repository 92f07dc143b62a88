//! Where readings go: [the bus](bus), or [a table on standard output](table) for a look in the field.

pub mod bus;
pub mod table;

use crate::failure::Failure;
use crate::wire::continuity::{Arrival, Totals};
use crate::wire::optoforce::{ByteCounts, DataFrame, DeviceStatus};

/// One valid frame and what is known about it.
#[derive(Clone, Copy, Debug)]
pub struct Reading {
    /// The frame.
    pub frame: DataFrame,
    /// How it relates to the frames before it.
    pub arrival: Arrival,
    /// Its number in the series that begins with 0 and has the device's gaps. Meaningful for frames that are newer than
    /// all before; a duplicate or late frame carries the number of the newest.
    pub sequence: u64,
    /// When it was true, ns of `CLOCK_MONOTONIC`; an estimate, see [`crate::stamping`].
    pub captured_ns: u64,
}

/// Everything counted so far.
#[derive(Clone, Copy, Debug, Default)]
pub struct Health {
    /// Where the bytes went.
    pub bytes: ByteCounts,
    /// What the counts of the frames say.
    pub continuity: Totals,
    /// Frames whose status reports an error or an overload.
    pub device_errors: u64,
    /// Status word of the newest frame.
    pub device_status: DeviceStatus,
    /// Whether data came within the last [`crate::driver::SILENCE`].
    pub alive: bool,
}

impl core::fmt::Display for Health {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
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

/// A place for readings.
pub trait Output {
    /// Takes the readings of one read from the device, in order of arrival.
    ///
    /// # Errors
    /// When the place is gone.
    fn readings(&mut self, readings: &[Reading]) -> Result<(), Failure>;

    /// Takes a regular report, about ten times a second and once at the end.
    ///
    /// # Errors
    /// When the place is gone.
    fn health(&mut self, health: &Health) -> Result<(), Failure>;
}
