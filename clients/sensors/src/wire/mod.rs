//! Sensors, one file each: messages of the device, messages to it, and the options of its
//! subcommand.
//!
//! A new sensor needs one file here, one entry in [`SENSORS`] (with its `mod`), and one table of
//! test vectors in `tests/vectors/`. This code reads no clock and opens no device, so property
//! tests cover all of it.

pub mod anyskin;
mod driver;
pub mod netft;
pub mod optoforce;
pub mod papillarray;
pub mod paxini;
pub mod paxini_hand;
pub mod uskin;

pub use driver::{DeviceMessages, Driver, Event, Interface, Make, Request, SensorType, Zero};

/// All supported sensors.
pub const SENSORS: [SensorType; 7] = [
    optoforce::TYPE,
    paxini::TYPE,
    paxini_hand::TYPE,
    anyskin::TYPE,
    netft::TYPE,
    uskin::TYPE,
    papillarray::TYPE,
];

/// Returns the sensor with this name.
#[must_use]
pub fn named(name: &str) -> Option<&'static SensorType> {
    SENSORS.iter().find(|sensor| sensor.name == name)
}
