//! Servo families, one file each: models, registers and configuration.
//!
//! To add a family, add a file with its `mod` and an entry in [`DRIVERS`]. `rustypot` implements
//! frames and checksums ([`wire`]). Positions, speeds and currents refer to the servo's shaft; the
//! [map](crate::map) handles joints, directions, zeros and gears.

mod driver;
pub mod dynamixel;
pub mod feetech;
mod packet_port;
pub mod protocol;
pub mod wire;

pub use driver::{Driver, Health, LimitKind, Model, Reading, Servo, State};

/// All supported families.
pub const DRIVERS: [&dyn Driver; 2] = [&dynamixel::Dynamixel, &feetech::Feetech];

/// Returns the family with this name.
#[must_use]
pub fn find(name: &str) -> Option<&'static dyn Driver> {
    DRIVERS.into_iter().find(|driver| driver.name() == name)
}
