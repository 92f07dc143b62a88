//! Input of a target, read as instructions: every byte sequence is a valid input.

use zerocopy::{FromBytes, Immutable, IntoBytes};

/// Values that arithmetic, ranges and comparisons treat specially.
const SPECIAL: [u64; 16] = [
    0,
    1,
    u64::MAX,
    u64::MAX - 1,
    1 << 63,
    (1 << 63) - 1,
    u32::MAX as u64,
    1 << 31,
    0x7FF8_0000_0000_0000, // NaN
    0x7FF0_0000_0000_0000, // infinity
    0xFFF0_0000_0000_0000, // negative infinity
    0x7FEF_FFFF_FFFF_FFFF, // largest f64
    0x0000_0000_0000_0003, // denormal
    0x8000_0000_0000_0000, // negative zero
    0x3FF0_0000_0000_0000, // 1.0
    0x7FC0_0000_7FC0_0000, // two f32 NaN
];

/// Reader of an input. Reading beyond its end yields zeros.
#[derive(Clone, Debug)]
pub struct Input<'a> {
    rest: &'a [u8],
}

impl<'a> Input<'a> {
    /// Begins at the first byte.
    #[must_use]
    pub fn new(bytes: &'a [u8]) -> Self {
        Self { rest: bytes }
    }

    /// Returns true if no byte is left.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.rest.is_empty()
    }

    /// Takes one byte.
    pub fn byte(&mut self) -> u8 {
        let [byte] = self.array();
        byte
    }

    /// Takes a little-endian `u16`.
    pub fn u16(&mut self) -> u16 {
        u16::from_le_bytes(self.array())
    }

    /// Takes a `u64`: eight bytes or one of the special values.
    pub fn u64(&mut self) -> u64 {
        match self.byte() {
            kind @ 0..=63 => SPECIAL[usize::from(kind) % SPECIAL.len()],
            64..=127 => u64::from(self.byte()),
            _ => u64::from_le_bytes(self.array()),
        }
    }

    /// Takes at most `count` bytes.
    pub fn bytes(&mut self, count: usize) -> &'a [u8] {
        let (taken, rest) = self.rest.split_at(count.min(self.rest.len()));
        self.rest = rest;
        taken
    }

    /// Takes all remaining bytes.
    pub fn rest(&mut self) -> &'a [u8] {
        self.bytes(usize::MAX)
    }

    fn array<const N: usize>(&mut self) -> [u8; N] {
        let mut array = [0; N];
        let taken = self.bytes(N);
        array[..taken.len()].copy_from_slice(taken);
        array
    }

    /// Overwrites up to seven places of a payload.
    pub fn patch<T: IntoBytes + FromBytes + Immutable>(&mut self, payload: &mut T) {
        self.patch_bytes(payload.as_mut_bytes());
    }

    /// Overwrites up to seven places with special or given values, or flips a bit.
    pub fn patch_bytes(&mut self, bytes: &mut [u8]) {
        for _ in 0..self.byte() % 8 {
            let (kind, place) = (self.byte(), usize::from(self.u16()));
            if bytes.is_empty() {
                return;
            }
            let place = place % bytes.len();
            let width = match kind % 4 {
                0 => {
                    bytes[place] ^= 1 << (kind >> 5);
                    continue;
                }
                1 => 1,
                2 => 4,
                _ => 8,
            };
            let value = self.u64().to_le_bytes();
            // Fields are aligned to their size.
            let begin = place - place % width;
            let end = bytes.len().min(begin + width);
            bytes[begin..end].copy_from_slice(&value[..end - begin]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exhausted_input_yields_zeros() {
        let mut input = Input::new(&[3, 1]);
        assert_eq!(
            (input.u16(), input.byte(), input.is_empty()),
            (0x0103, 0, true)
        );
        let mut bytes = [7; 5];
        input.patch_bytes(&mut bytes);
        assert_eq!(bytes, [7; 5]);
    }

    #[test]
    fn patches_stay_inside_the_payload() {
        for kind in 0..=255 {
            let instructions = [7, kind, 254, 255, 200, 1, 2, 3, 4, 5, 6, 7, 8];
            let mut bytes = [0; 5];
            Input::new(&instructions).patch_bytes(&mut bytes);
            Input::new(&instructions).patch_bytes(&mut []);
        }
    }
}
