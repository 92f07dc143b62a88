//! Random noise of one frame: inverted sensors and slipping wheels.
//!
//! Integers only, drawn independently of the agents' actions: all engines draw the same noise.

use serde::{Deserialize, Serialize};

use crate::responses::Wheels;

/// Bits of a random word per event.
pub(crate) const EVENT_BITS: u32 = 10;
pub(crate) const EVENT_MASK: u32 = (1 << EVENT_BITS) - 1;
/// Shifts of one step of a stream (Marsaglia 2003, "Xorshift RNGs").
pub(crate) const XORSHIFT: [u32; 3] = [13, 17, 5];

/// Noise probabilities per frame, in 1/1024.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Noise {
    /// Inversion of a sensor; 512 makes it useless.
    pub sensor_flips_per_1024: u16,
    /// Slip of a wheel, which then stands still; 1024 stops all agents.
    pub wheel_slips_per_1024: u16,
}

impl Noise {
    /// No noise.
    pub const NONE: Self = Self {
        sensor_flips_per_1024: 0,
        wheel_slips_per_1024: 0,
    };

    /// Returns true without noise.
    #[must_use]
    pub fn is_none(self) -> bool {
        self == Self::NONE
    }
}

/// State of a trial's random stream. Never 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Stream(pub(crate) u32);

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct FrameNoise {
    /// Inverted bits of the row.
    pub(crate) flips: u8,
    /// True if the left or right wheel slips.
    pub(crate) slips: [bool; 2],
}

impl Stream {
    pub(crate) fn word(&mut self) -> u32 {
        let [left, right, last] = XORSHIFT;
        self.0 ^= self.0 << left;
        self.0 ^= self.0 >> right;
        self.0 ^= self.0 << last;
        self.0
    }

    /// Draws the noise of each agent; returns it with the stream of the next frame. Three words per
    /// agent: IR sensors, photo sensors, wheels.
    pub(crate) fn frame<const MOST: usize>(
        mut self,
        noise: Noise,
        agents: usize,
    ) -> ([FrameNoise; MOST], Self) {
        let mut upsets = [FrameNoise::default(); MOST];
        if noise.is_none() {
            return (upsets, self);
        }
        let (flip, slip) = (noise.sensor_flips_per_1024, noise.wheel_slips_per_1024);
        for upset in &mut upsets[..agents] {
            let (ir, photo, wheels) = (self.word(), self.word(), self.word());
            let flips = [
                event_occurs(ir, 0, flip),
                event_occurs(ir, 1, flip),
                event_occurs(ir, 2, flip),
                event_occurs(photo, 0, flip),
                event_occurs(photo, 1, flip),
            ];
            let row = |row, &flip: &bool| row << 1 | u8::from(flip);
            *upset = FrameNoise {
                flips: flips.iter().rev().fold(0, row),
                slips: [0, 1].map(|wheel| event_occurs(wheels, wheel, slip)),
            };
        }
        (upsets, self)
    }
}

impl FrameNoise {
    pub(crate) fn apply_slip(self, wheels: Wheels) -> Wheels {
        let level = |level, slips: bool| if slips { 0 } else { level };
        Wheels {
            left: level(wheels.left, self.slips[0]),
            right: level(wheels.right, self.slips[1]),
        }
    }
}

/// Returns true if the event of the `place`-th ten bits occurs, at probability `parts` / 1024.
fn event_occurs(word: u32, place: u32, parts: u16) -> bool {
    ((word >> (place * EVENT_BITS)) & EVENT_MASK) + u32::from(parts) > EVENT_MASK
}

/// Derives a layout's seed from the bits of its numbers.
pub(crate) fn seed(numbers: impl Iterator<Item = f32>) -> u32 {
    // Multiplier and shifts of SplitMix64, so that similar layouts get uncorrelated streams.
    let mix = |state: u64, number: f32| {
        let z = (state ^ u64::from(number.to_bits())).wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (z ^ z >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z ^ z >> 27
    };
    (numbers.fold(0, mix) >> 32) as u32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn event_rates_match_their_probabilities() {
        const FRAMES: u32 = if cfg!(miri) { 200 } else { 20_000 };
        // Four standard deviations of the rate.
        let tolerance = 4.0 * 0.5 / f64::from(FRAMES).sqrt();
        for parts in [0, 1, 51, 512, 1024] {
            let noise = Noise {
                sensor_flips_per_1024: parts,
                wheel_slips_per_1024: parts,
            };
            let (mut stream, mut flips, mut slips) = (Stream(7), [0_u32; 5], [0_u32; 2]);
            for _ in 0..FRAMES {
                let (upsets, next) = stream.frame::<4>(noise, 2);
                stream = next;
                for (bit, count) in flips.iter_mut().enumerate() {
                    *count += u32::from(upsets[1].flips >> bit & 1);
                }
                for (slip, count) in upsets[1].slips.iter().zip(&mut slips) {
                    *count += u32::from(*slip);
                }
                assert_eq!(upsets[2], FrameNoise::default(), "agent outside the team");
            }
            let expected = f64::from(parts) / 1024.0;
            for count in flips.into_iter().chain(slips) {
                let rate = f64::from(count) / f64::from(FRAMES);
                assert!(
                    (rate - expected).abs() < tolerance,
                    "{parts} of 1024: {flips:?} {slips:?}"
                );
            }
        }
    }
}
