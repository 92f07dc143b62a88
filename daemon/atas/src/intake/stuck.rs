//! Elements that are stuck: a reading that used to move, stands still bit by bit although frames keep coming, and is no zero.
//!
//! A living element has noise, a quantised one at least while it is pressed. One that stops being alive keeps what it read last, and
//! a hand that believes it feels a force that is gone, or misses one that comes. What never moved (an element that nothing touches,
//! quantised more coarsely than its noise) and what stands at zero harms nobody and is left alone. Rests count while most others move,
//! and an element that has rested for long before may rest several times as long again.

use shm_schemas::capacity::ELEMENTS;

/// Frames in which an element must have moved before it is known to be alive (ours: a quarter of a second of a 1 kHz sensor).
const ALIVE_FRAMES: u16 = 250;
/// Frames without a change from which on it is stuck (ours; fault catalogue F15: flagged within 1000).
const STUCK_FRAMES: u16 = 250;
/// Multiple of its longest rest while it was alive (ours: coarsely quantised readings rest now and then).
const REST_FACTOR: u16 = 4;
/// Size of a reading that is no zero, N (ours: several times the noise of an element).
const ZERO_N: f32 = 0.01;

/// The elements of one fingertip; a bit of a set is an element.
#[derive(Clone, Copy, Debug)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct StuckWatch {
    /// Those that are known to be alive, and those of them that rest.
    alive: u64,
    resting: u64,
    /// Frames in which each has moved, while it is not known to be alive.
    #[cfg_attr(feature = "serde", serde(with = "serde_big_array::BigArray"))]
    moved: [u16; ELEMENTS],
    /// Frames for which each rests, and the longest such rest so far.
    #[cfg_attr(feature = "serde", serde(with = "serde_big_array::BigArray"))]
    rests: [u16; ELEMENTS],
    #[cfg_attr(feature = "serde", serde(with = "serde_big_array::BigArray"))]
    longest: [u16; ELEMENTS],
}

impl Default for StuckWatch {
    fn default() -> Self {
        Self {
            alive: 0,
            resting: 0,
            moved: [0; ELEMENTS],
            rests: [0; ELEMENTS],
            longest: [0; ELEMENTS],
        }
    }
}

impl StuckWatch {
    /// Takes in a frame's readings, N, and those of the frame before; returns which of the first `count` elements are stuck.
    pub(super) fn look(
        &mut self,
        before_n: &[[f32; 3]; ELEMENTS],
        now_n: &[[f32; 3]; ELEMENTS],
        count: usize,
    ) -> u64 {
        let mut moved = 0_u64;
        for (element, (before, now)) in before_n.iter().zip(now_n).take(count).enumerate() {
            // Bit by bit: what is not a number is masked already.
            let change = |axis: usize| before[axis].to_bits() ^ now[axis].to_bits();
            let moves = change(0) | change(1) | change(2) != 0;
            moved |= u64::from(moves) << element;
        }
        // Where all rest together, nobody is stuck: a sensor without noise, or a frame that came twice.
        let speaks = 2 * (moved & self.alive).count_ones() >= self.alive.count_ones();
        for element in each(moved & (self.resting | !self.alive)) {
            self.move_on(element);
        }
        let mut stuck = 0;
        for element in each(self.alive & !moved) {
            if !is_zero(&now_n[element]) {
                stuck |= u64::from(self.rest(element, speaks)) << element;
            }
        }
        stuck
    }

    /// An element rests; whether it is stuck.
    fn rest(&mut self, element: usize, speaks: bool) -> bool {
        self.resting |= 1 << element;
        self.rests[element] = self.rests[element].saturating_add(u16::from(speaks));
        let allowed = self.longest[element].saturating_mul(REST_FACTOR);
        self.rests[element] >= STUCK_FRAMES.max(allowed)
    }

    /// An element that rested, or is not known to be alive, moves.
    fn move_on(&mut self, element: usize) {
        let rests = core::mem::take(&mut self.rests[element]);
        self.resting &= !(1 << element);
        if rests < STUCK_FRAMES {
            self.longest[element] = self.longest[element].max(rests);
        }
        self.moved[element] = self.moved[element].saturating_add(1);
        self.alive |= u64::from(self.moved[element] >= ALIVE_FRAMES) << element;
    }
}

/// The elements of a set.
fn each(mut set: u64) -> impl Iterator<Item = usize> {
    core::iter::from_fn(move || {
        let element = (set != 0).then(|| set.trailing_zeros() as usize);
        set &= set.wrapping_sub(1);
        element
    })
}

fn is_zero(reading_n: &[f32; 3]) -> bool {
    reading_n.iter().all(|axis| axis.abs() < ZERO_N)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Frames after which an element is stuck that follows `reading`, of 3000.
    fn stuck_after(reading: impl Fn(u16) -> f32) -> Option<u16> {
        let mut watch = StuckWatch::default();
        let mut before_n = [[0.0; 3]; ELEMENTS];
        (0..3000).find(|frame| {
            let mut now_n = before_n;
            now_n[3] = [reading(*frame), 0.0, 0.0];
            now_n[1] = [alive(*frame), 0.0, 0.0];
            let stuck = watch.look(&before_n, &now_n, 5);
            before_n = now_n;
            assert!(stuck == 0 || stuck == 1 << 3, "{stuck:b}");
            stuck != 0
        })
    }

    /// A living reading: it moves with every frame.
    fn alive(frame: u16) -> f32 {
        0.2 + f32::from(frame % 7) * 1e-3
    }

    #[test]
    fn only_what_lived_and_rests_beside_zero_is_stuck() {
        let check = |name: &str, reading: &dyn Fn(u16) -> f32, expected: Option<u16>| {
            assert_eq!(stuck_after(reading), expected, "{name}");
        };
        check("alive", &alive, None);
        check(
            "dead from 1000 on",
            &|frame| alive(frame.min(1000)),
            Some(1250),
        );
        check("never moved", &|_| 0.2, None);
        let at_zero = |frame: u16| if frame < 1000 { alive(frame) } else { 0.0 };
        check("rests at zero", &at_zero, None);
        // Moves every hundredth frame only: four of its rests are not over.
        check("coarse", &|frame| alive(frame / 100), None);
        let coarse = |frame: u16| alive(frame.min(1000) / 2);
        check("coarse, then dead", &coarse, Some(1250));
        let back = |frame: u16| {
            if frame < 1240 {
                alive(frame.min(1000))
            } else {
                alive(frame)
            }
        };
        check("back in time", &back, None);
    }
}
