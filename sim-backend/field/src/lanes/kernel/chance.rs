//! Noise over lanes: draws of [`crate::noise`] in the same order.

use super::Fields;
use crate::chance::{PART_BITS, PARTS_LOG2, XORSHIFT};
use crate::lanes::{Ints, Lanes};

impl<T: Lanes, const N: usize, const WALLED: bool> Fields<'_, T, N, WALLED> {
    /// `ir` as 4 left, 8 front, 16 right.
    #[inline(always)]
    pub(super) fn mislead(&mut self, ir: T::Ints, photo: [T::Mask; 2]) -> (T::Ints, [T::Mask; 2]) {
        let flip = self.c.noise.sensor_flips_per_1024;
        let word = self.draw();
        let (left, front, right) = (
            self.happens(word, 0, flip),
            self.happens(word, 1, flip),
            self.happens(word, 2, flip),
        );
        let flips = left.shl(self.int(2)) | front.shl(self.int(3)) | right.shl(self.int(4));
        let word = self.draw();
        let seen = [
            self.seen(photo[0], self.happens(word, 0, flip)),
            self.seen(photo[1], self.happens(word, 1, flip)),
        ];
        (ir ^ flips, seen)
    }

    /// Inverts a photo sensor where `flip` is 1.
    #[inline(always)]
    fn seen(&self, light: T::Mask, flip: T::Ints) -> T::Mask {
        T::is_zero(self.bit(light, 1) ^ self.int(1) ^ flip)
    }

    /// Clears the levels of slipping wheels in a code.
    #[inline(always)]
    pub(super) fn slip(&mut self, code: T::Ints) -> T::Ints {
        let slip = self.c.noise.wheel_slips_per_1024;
        let word = self.draw();
        let (left, right) = (self.happens(word, 0, slip), self.happens(word, 1, slip));
        let stands = left | left.shl(self.int(1)) | right.shl(self.int(2)) | right.shl(self.int(3));
        code & (stands ^ self.int(0b1111))
    }

    #[inline(always)]
    fn draw(&mut self) -> T::Ints {
        let [left, right, last] = [
            self.int(XORSHIFT[0] as i32),
            self.int(XORSHIFT[1] as i32),
            self.int(XORSHIFT[2] as i32),
        ];
        let word = self.noise ^ self.noise.shl(left);
        let word = word ^ word.shr(right);
        self.noise = word ^ word.shl(last);
        self.noise
    }

    /// Returns 1 where the event of the `place`-th ten bits occurs, at probability `parts` / 1024.
    #[inline(always)]
    fn happens(&self, word: T::Ints, place: i32, parts: u16) -> T::Ints {
        let drawn = word.shr(self.int(place * PARTS_LOG2 as i32)) & self.int(PART_BITS as i32);
        (drawn + self.int(parts.into())).shr(self.int(PARTS_LOG2 as i32))
    }
}
