//! Status word of a data frame.

/// Status of the device. Bits 15–13 converter error, 12–10 sensor error, 9–4 overload of Fx, Fy,
/// Fz, Tx, Ty, Tz, 3 several sensors affected, 2–0 number of the affected sensor (vendor's
/// protocol).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct DeviceStatus(
    /// Received word.
    pub u16,
);

impl DeviceStatus {
    /// Returns the error code of the data-acquisition converter; 0 without an error.
    #[must_use]
    pub const fn converter_error(self) -> u16 {
        self.0 >> 13
    }

    /// Returns the error code of the sensor; 0 without an error.
    #[must_use]
    pub const fn sensor_error(self) -> u16 {
        self.0 >> 10 & 0b111
    }

    /// Returns the overloaded axes, bit 5 Fx to bit 0 Tz: the reading is a lower bound.
    #[must_use]
    pub const fn overload(self) -> u16 {
        self.0 >> 4 & 0b11_1111
    }

    /// Returns true if more than one sensor is affected.
    #[must_use]
    pub const fn several_sensors(self) -> bool {
        self.0 >> 3 & 1 == 1
    }

    /// Returns the number of the affected sensor.
    #[must_use]
    pub const fn sensor_number(self) -> u16 {
        self.0 & 0b111
    }

    /// Returns true if the readings are invalid: converter or sensor report an error. An overload
    /// is not a failure, because a saturated reading is still a lower bound.
    #[must_use]
    pub const fn is_failed(self) -> bool {
        self.converter_error() != 0 || self.sensor_error() != 0
    }

    /// Returns true if the device reports any error or overload.
    #[must_use]
    pub const fn is_abnormal(self) -> bool {
        self.is_failed() || self.overload() != 0
    }
}

impl core::fmt::Display for DeviceStatus {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        write!(f, "{:#06x}", self.0)?;
        if self.is_abnormal() {
            write!(
                f,
                " (converter error {}, sensor error {}, overload {:#08b}, sensor {}{})",
                self.converter_error(),
                self.sensor_error(),
                self.overload(),
                self.sensor_number(),
                if self.several_sensors() {
                    " and others"
                } else {
                    ""
                },
            )?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::DeviceStatus;

    #[test]
    fn status_fields_match_the_protocol() {
        let check = |word, fields, failed, abnormal| {
            let s = DeviceStatus(word);
            let found = (
                s.converter_error(),
                s.sensor_error(),
                s.overload(),
                s.several_sensors(),
                s.sensor_number(),
            );
            assert_eq!(
                (found, s.is_failed(), s.is_abnormal()),
                (fields, failed, abnormal),
                "{word:#06x}"
            );
        };
        check(0x0000, (0, 0, 0, false, 0), false, false);
        check(0x2000, (1, 0, 0, false, 0), true, true);
        check(0x1002, (0, 4, 0, false, 2), true, true);
        check(0x0200, (0, 0, 0b10_0000, false, 0), false, true);
        check(0x000F, (0, 0, 0, true, 7), false, false);
        check(0xFFFF, (7, 7, 0b11_1111, true, 7), true, true);
    }
}
