//! The sensors, one file each: what a device sends, what it is told, and the options of its subcommand.
//!
//! A further sensor is one file here, one line in [`SENSORS`] (with its `mod`), and one table of test vectors in
//! `tests/vectors/`. Nothing here reads a clock or opens a device, so property tests can hammer all of it.

pub mod anyskin;
mod driver;
pub mod netft;
pub mod optoforce;
pub mod papillarray;
pub mod paxini;
pub mod paxini_hand;
pub mod uskin;

pub use driver::{Dialogue, Driver, Event, Make, Request, SensorType, Way, Zero};

/// Every sensor that can be read.
pub const SENSORS: [SensorType; 7] = [
    optoforce::TYPE,
    paxini::TYPE,
    paxini_hand::TYPE,
    anyskin::TYPE,
    netft::TYPE,
    uskin::TYPE,
    papillarray::TYPE,
];

/// The sensor with this name.
#[must_use]
pub fn named(name: &str) -> Option<&'static SensorType> {
    SENSORS.iter().find(|sensor| sensor.name == name)
}
