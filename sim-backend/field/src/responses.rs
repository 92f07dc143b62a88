//! Response table of an agent: wheel levels per combination of its five sensors.

/// Sensors of an agent: IR left, front, right, photo left, right (paper Fig. 10).
pub const SENSORS: usize = 5;
/// Rows of a table: combinations of the sensors (paper III.a).
pub const ROWS: usize = 1 << SENSORS;

/// Wheel levels of one frame: 0 stop, 1 medium, 2 high (paper Table 1).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
pub struct Wheels {
    /// Left wheel.
    pub left: u8,
    /// Right wheel.
    pub right: u8,
}

impl Wheels {
    /// Both wheels stopped.
    pub const STOP: Self = Self { left: 0, right: 0 };

    /// Encodes four motor bits, lowest first: L1, L2, R1, R2 (paper Table 1). Levels above 2 count
    /// as 2.
    #[must_use]
    pub fn motor_bits(self) -> u32 {
        let pair = |level: u8| (1_u32 << level.min(2)) - 1;
        pair(self.left) | pair(self.right) << 2
    }

    /// Decodes four motor bits, lowest first: L1, L2, R1, R2. A level is the number of its set bits
    /// (paper Table 1).
    #[must_use]
    #[inline]
    pub fn from_motor_bits(bits: u32) -> Self {
        let level = |pair: u32| (pair & 3).count_ones() as u8;
        Self {
            left: level(bits),
            right: level(bits >> 2),
        }
    }
}

/// One [`Wheels`] per row. Row index: IR left 1 + front 2 + right 4 + photo left 8 + right 16.
///
/// Four bits per row: left level in bits 0–1, right level in bits 2–3.
///
/// ```
/// use field::{Responses, Wheels};
///
/// // One response per row: drive ahead when the first sensor is set, else stop.
/// let table = Responses::from_fn(|row| match row & 1 {
///     1 => Wheels { left: 2, right: 2 },
///     _ => Wheels::STOP,
/// });
/// assert_eq!(table.get(3), Wheels { left: 2, right: 2 });
/// assert_eq!(Responses::from_fn(|row| table.get(row as u8)), table);
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
pub struct Responses(u128);

impl Responses {
    /// Packs one response per row. Levels above 2 count as 2.
    #[must_use]
    pub fn from_fn(mut response: impl FnMut(usize) -> Wheels) -> Self {
        Self((0..ROWS).fold(0, |bits, row| {
            let Wheels { left, right } = response(row);
            let code = u128::from(left.min(2)) | u128::from(right.min(2)) << 2;
            bits | code << (4 * row)
        }))
    }

    /// Packs two motor bits per wheel (paper Table 1): bit 4r is L1 of row r, then L2, R1, R2.
    #[must_use]
    pub fn from_motor_bits(bits: u128) -> Self {
        const FIRST: u128 = u128::MAX / 3;
        let (first, second) = (bits & FIRST, bits >> 1 & FIRST);
        Self(first ^ second | (first & second) << 1)
    }

    /// Returns the levels of a row, taken modulo 32.
    #[must_use]
    #[inline]
    pub fn get(self, row: u8) -> Wheels {
        let code = (self.0 >> (4 * (u32::from(row) % 32))) as u8;
        Wheels {
            left: code & 3,
            right: code >> 2 & 3,
        }
    }

    /// Returns the packed bits, row 0 lowest.
    #[must_use]
    #[inline]
    pub fn bits(self) -> u128 {
        self.0
    }

    /// Returns the mask of the rows in the set `rows`. Tables equal under it behave identically
    /// while only these rows are read.
    #[must_use]
    #[inline]
    pub fn row_mask(rows: u32) -> u128 {
        // Move bit r to bit 4r, then fill each nibble.
        let mut spread = u128::from(rows);
        for (shift, mask) in [
            (48, 0x0000_0000_0000_ffff_0000_0000_0000_ffff_u128),
            (24, 0x0000_00ff_0000_00ff_0000_00ff_0000_00ff),
            (12, 0x000f_000f_000f_000f_000f_000f_000f_000f),
            (6, 0x0303_0303_0303_0303_0303_0303_0303_0303),
            (3, 0x1111_1111_1111_1111_1111_1111_1111_1111),
        ] {
            spread = (spread | spread << shift) & mask;
        }
        spread * 15
    }

    /// Returns four words; word `w` holds the eight rows with photo sensors `w` (bit 0 left, bit 1
    /// right).
    #[inline]
    pub(crate) fn words(self) -> [i32; 4] {
        [0, 32, 64, 96].map(|shift| (self.0 >> shift) as u32 as i32)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn packed_rows_round_trip() {
        let wheels = |row: usize| Wheels {
            left: (row % 3) as u8,
            right: (row / 3 % 3) as u8,
        };
        let table = Responses::from_fn(wheels);
        for row in 0..ROWS {
            assert_eq!(table.get(row as u8), wheels(row), "row {row}");
            assert_eq!(
                Wheels::from_motor_bits(wheels(row).motor_bits()),
                wheels(row)
            );
        }
    }

    #[test]
    fn level_counts_set_motor_bits() {
        let table = Responses::from_motor_bits(0x0123_4567_89ab_cdef << 64 | 0xfedc_ba98_7654_3210);
        for row in 0..16_u8 {
            let ones = |bits: u8| bits.count_ones() as u8;
            let expected = Wheels {
                left: ones(row & 3),
                right: ones(row >> 2),
            };
            assert_eq!(table.get(row), expected, "row {row}");
            assert_eq!(Wheels::from_motor_bits(u32::from(row)), expected, "{row}");
        }
    }

    #[test]
    fn row_mask_covers_the_nibbles_of_its_rows() {
        for rows in [0, 1, 0x8000_0000, 0x0001_0280, 0xdead_beef, u32::MAX] {
            let expected = (0..32)
                .filter(|r| rows >> r & 1 == 1)
                .fold(0u128, |m, r| m | 15 << (4 * r));
            assert_eq!(Responses::row_mask(rows), expected, "rows {rows:#x}");
        }
    }
}
