//! Configuration message to the device.

use super::checksum;

/// Frame rate of the device, by its speed code.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Speed {
    code: u8,
    rate_hz: u32,
}

/// Cut-off of the device's low-pass, by its filter code.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Filter {
    code: u8,
}

/// Error: a rate or cut-off that the device does not have.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error("the device has no {quantity} of {value} Hz, needs one of {allowed}")]
pub struct OutOfRange {
    quantity: &'static str,
    value: f64,
    allowed: &'static str,
}

/// Rates, Hz, and their codes: the code is the period in ms (vendor's protocol).
const SPEEDS: [(u32, u8); 5] = [(1000, 1), (333, 3), (100, 10), (30, 33), (10, 100)];

/// Cut-offs, Hz, and their codes; 0 Hz stands for "no filter" (vendor's protocol).
const FILTERS: [(f64, u8); 7] = [
    (0.0, 0),
    (500.0, 1),
    (150.0, 2),
    (50.0, 3),
    (15.0, 4),
    (5.0, 5),
    (1.5, 6),
];

impl Speed {
    /// Returns the speed with this rate.
    ///
    /// # Errors
    /// The device has no such rate.
    pub fn from_hz(rate_hz: u32) -> Result<Self, OutOfRange> {
        let known = SPEEDS.iter().find(|(rate, _)| *rate == rate_hz);
        known
            .map(|&(rate_hz, code)| Self { code, rate_hz })
            .ok_or(OutOfRange {
                quantity: "rate",
                value: f64::from(rate_hz),
                allowed: "1000, 333, 100, 30, 10",
            })
    }

    /// Returns the nominal time between two frames, ns.
    #[must_use]
    pub fn period_ns(self) -> u64 {
        1_000_000_000 / u64::from(self.rate_hz)
    }
}

impl Filter {
    /// Returns the filter with this cut-off; 0 for none.
    ///
    /// # Errors
    /// The device has no such filter.
    pub fn from_hz(cutoff_hz: f64) -> Result<Self, OutOfRange> {
        let known = FILTERS.iter().find(|(cutoff, _)| *cutoff == cutoff_hz);
        known.map(|&(_, code)| Self { code }).ok_or(OutOfRange {
            quantity: "filter",
            value: cutoff_hz,
            allowed: "0 (none), 1.5, 5, 15, 50, 150, 500",
        })
    }
}

/// Settings of the device. It acknowledges them and keeps them until power-off.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Configuration {
    /// Frame rate.
    pub speed: Speed,
    /// Low-pass.
    pub filter: Filter,
    /// True to make the present load zero.
    pub zero: bool,
}

impl Configuration {
    /// Returns the bytes of the message.
    #[must_use]
    pub fn to_bytes(self) -> [u8; 9] {
        message(
            self.speed.code,
            self.filter.code,
            if self.zero { 255 } else { 0 },
        )
    }
}

/// Message that stops the stream: speed 0, zero kept.
pub const STOP: [u8; 9] = [0xAA, 0x00, 0x32, 0x03, 0, 0, 0, 0x00, 0xDF];

fn message(speed: u8, filter: u8, zero: u8) -> [u8; 9] {
    let mut bytes = [0xAA, 0x00, 0x32, 0x03, speed, filter, zero, 0, 0];
    let sum = checksum(&bytes[..7]);
    bytes[7..].copy_from_slice(&sum.to_be_bytes());
    bytes
}

#[cfg(test)]
mod tests {
    use super::{Configuration, Filter, STOP, Speed, message};

    #[test]
    fn messages_match_the_protocol() {
        let check = |rate_hz, cutoff_hz, zero, bytes: [u8; 9]| {
            let speed = Speed::from_hz(rate_hz).unwrap();
            let filter = Filter::from_hz(cutoff_hz).unwrap();
            assert_eq!(
                Configuration {
                    speed,
                    filter,
                    zero
                }
                .to_bytes(),
                bytes
            );
        };
        check(
            100,
            15.0,
            true,
            [0xAA, 0x00, 0x32, 0x03, 10, 4, 255, 0x01, 0xEC],
        );
        check(
            1000,
            0.0,
            false,
            [0xAA, 0x00, 0x32, 0x03, 1, 0, 0, 0x00, 0xE0],
        );
        check(
            10,
            1.5,
            false,
            [0xAA, 0x00, 0x32, 0x03, 100, 6, 0, 0x01, 0x49],
        );
        assert_eq!(STOP, message(0, 0, 0));
    }

    #[test]
    fn unknown_setting_is_rejected_with_allowed_ones() {
        let rate = Speed::from_hz(500).unwrap_err().to_string();
        assert_eq!(
            rate,
            "the device has no rate of 500 Hz, needs one of 1000, 333, 100, 30, 10"
        );
        for cutoff_hz in [f64::NAN, f64::INFINITY, -1.0, 16.0] {
            let filter = Filter::from_hz(cutoff_hz).unwrap_err().to_string();
            assert!(filter.contains("0 (none), 1.5, 5"), "{filter}");
        }
    }
}
