//! Noise over lanes: draws of [`crate::noise`] in the same order.

use super::Fields;
use crate::lanes::{Ints, Lanes};
use crate::noise::{EVENT_BITS, EVENT_MASK, XORSHIFT};

impl<T: Lanes, const N: usize, const WALLED: bool> Fields<'_, T, N, WALLED> {
    /// `ir` as 4 left, 8 front, 16 right.
    #[inline(always)]
    pub(super) fn apply_sensor_noise(
        &mut self,
        ir: T::Ints,
        photo: [T::Mask; 2],
    ) -> (T::Ints, [T::Mask; 2]) {
        let flip = self.c.noise.sensor_flips_per_1024;
        let word = self.draw();
        let (left, front, right) = (
            self.event_occurs(word, 0, flip),
            self.event_occurs(word, 1, flip),
            self.event_occurs(word, 2, flip),
        );
        let flips = left.shl(self.int(2)) | front.shl(self.int(3)) | right.shl(self.int(4));
        let word = self.draw();
        let seen = [
            self.noisy_photo(photo[0], self.event_occurs(word, 0, flip)),
            self.noisy_photo(photo[1], self.event_occurs(word, 1, flip)),
        ];
        (ir ^ flips, seen)
    }

    /// Inverts a photo sensor where `flip` is 1.
    #[inline(always)]
    fn noisy_photo(&self, light: T::Mask, flip: T::Ints) -> T::Mask {
        T::is_zero(self.bit(light, 1) ^ self.int(1) ^ flip)
    }

    /// Clears the levels of slipping wheels in a code.
    #[inline(always)]
    pub(super) fn apply_slip(&mut self, code: T::Ints) -> T::Ints {
        let slip = self.c.noise.wheel_slips_per_1024;
        let word = self.draw();
        let (left, right) = (
            self.event_occurs(word, 0, slip),
            self.event_occurs(word, 1, slip),
        );
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
    fn event_occurs(&self, word: T::Ints, place: i32, parts: u16) -> T::Ints {
        let drawn = word.shr(self.int(place * EVENT_BITS as i32)) & self.int(EVENT_MASK as i32);
        (drawn + self.int(parts.into())).shr(self.int(EVENT_BITS as i32))
    }
}
