//! The servo families, one file each: their models, their registers, and how a servo is made ready.
//!
//! A further family is one file here and one line in [`DRIVERS`] (with its `mod`). What passes over the port, framing and
//! checksums, is `rustypot`'s ([`wire`]). Positions, speeds and currents here are those of the servo's own shaft; joints,
//! directions, zeros and gears are the [map](crate::map)'s.

mod driver;
pub mod dynamixel;
pub mod feetech;
pub mod wire;

pub use driver::{Driver, Health, LimitKind, Model, Reading, Servo, State};

/// Every family that can be driven.
pub const DRIVERS: [&dyn Driver; 2] = [&dynamixel::Dynamixel, &feetech::Feetech];

/// The family with this name.
#[must_use]
pub fn named(name: &str) -> Option<&'static dyn Driver> {
    DRIVERS.into_iter().find(|driver| driver.name() == name)
}
