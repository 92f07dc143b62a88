//! Assignment of sensors to the columns S1–S5 of a table. The paper only defines S4 and S5 as the
//! photo sensors, so the order is part of a condition.

use std::fmt;
use std::str::FromStr;

use serde::{Deserialize, Serialize};

use field::{ROWS, Responses, SENSORS};

/// Sensor of the mobile robot (paper Fig. 10). The number is its bit in a row of the field.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[expect(missing_docs, reason = "the names are self-explanatory")]
pub enum Sensor {
    IrLeft = 0,
    IrFront = 1,
    IrRight = 2,
    PhotoLeft = 3,
    PhotoRight = 4,
}

/// Sensor of every column, S1 first; each sensor once.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(try_from = "[Sensor; SENSORS]", into = "[Sensor; SENSORS]")]
pub struct SensorOrder([Sensor; SENSORS]);

impl Default for SensorOrder {
    /// Left to right, infrared before photo.
    fn default() -> Self {
        Self([
            Sensor::IrLeft,
            Sensor::IrFront,
            Sensor::IrRight,
            Sensor::PhotoLeft,
            Sensor::PhotoRight,
        ])
    }
}

/// Error: the order omits or repeats a sensor.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "could not use the sensor order: it is not a permutation, needs each of ir-left, ir-front, \
     ir-right, photo-left, photo-right once; name every sensor once"
)]
pub struct SensorOrderError;

impl TryFrom<[Sensor; SENSORS]> for SensorOrder {
    type Error = SensorOrderError;

    fn try_from(order: [Sensor; SENSORS]) -> Result<Self, SensorOrderError> {
        let seen = order
            .iter()
            .fold(0_u32, |seen, &sensor| seen | 1 << sensor as u32);
        if seen == (1 << SENSORS) - 1 {
            Ok(Self(order))
        } else {
            Err(SensorOrderError)
        }
    }
}

impl From<SensorOrder> for [Sensor; SENSORS] {
    fn from(order: SensorOrder) -> Self {
        order.0
    }
}

impl FromStr for SensorOrder {
    type Err = SensorOrderError;

    fn from_str(text: &str) -> Result<Self, SensorOrderError> {
        let sensor = |name: &str| {
            Ok(match name.trim() {
                "ir-left" => Sensor::IrLeft,
                "ir-front" => Sensor::IrFront,
                "ir-right" => Sensor::IrRight,
                "photo-left" => Sensor::PhotoLeft,
                "photo-right" => Sensor::PhotoRight,
                _ => return Err(SensorOrderError),
            })
        };
        let names = text.split(',').map(sensor).collect::<Result<Vec<_>, _>>()?;
        <[Sensor; SENSORS]>::try_from(names)
            .map_err(|_| SensorOrderError)?
            .try_into()
    }
}

impl fmt::Display for SensorOrder {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let name = |sensor: &Sensor| match sensor {
            Sensor::IrLeft => "ir-left",
            Sensor::IrFront => "ir-front",
            Sensor::IrRight => "ir-right",
            Sensor::PhotoLeft => "photo-left",
            Sensor::PhotoRight => "photo-right",
        };
        f.write_str(&self.0.each_ref().map(name).join(","))
    }
}

impl SensorOrder {
    /// Returns the table row of a field row.
    #[must_use]
    pub fn table_row(self, field_row: u8) -> usize {
        (0..SENSORS).fold(0, |row, column| {
            row | usize::from(field_row >> self.0[column] as u8 & 1) << column
        })
    }

    /// Returns the table rows of a set of field rows, one bit per row.
    #[must_use]
    pub fn table_rows(self, field_rows: u32) -> u32 {
        (0..32)
            .filter(|row| field_rows >> row & 1 == 1)
            .fold(0, |rows, row| rows | 1 << self.table_row(row))
    }

    /// Converts the 128 bits of a mobile robot's table to the form that the field's simulators use.
    #[must_use]
    pub fn responses(self, table_bits: u128) -> Responses {
        if self == Self::default() {
            return Responses::from_motor_bits(table_bits);
        }
        let row_bits = |field_row: usize| {
            (table_bits >> (4 * self.table_row(field_row as u8)) & 15) << (4 * field_row)
        };
        Responses::from_motor_bits((0..ROWS).fold(0, |bits, row| bits | row_bits(row)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn order_round_trips_and_permutes_rows() {
        let order: SensorOrder = "photo-left,ir-front,ir-right,ir-left,photo-right"
            .parse()
            .expect("an order");
        assert_eq!(order.to_string().parse(), Ok(order));
        assert_eq!(order.table_row(0b01000), 0b00001, "photo left is S1");
        assert_eq!(order.table_row(0b00001), 0b01000, "IR left is S4");
        assert_eq!(order.table_rows(0b1 | 1 << 8), 0b11);
        assert_eq!(SensorOrder::default().table_rows(0xdead_beef), 0xdead_beef);
    }

    #[test]
    fn non_permutation_is_rejected() {
        for text in [
            "",
            "ir-left",
            "ir-left,ir-left,ir-right,photo-left,photo-right",
            "a,b,c,d,e",
        ] {
            assert_eq!(
                text.parse::<SensorOrder>(),
                Err(SensorOrderError),
                "{text:?}"
            );
        }
    }
}
