//! Random numbers: SplitMix64, one stream per run. The bits of a run depend only on its seed.
//!
//! The generator is implemented here because checkpoints store its state and published tables
//! depend on its bits. An external crate could change either with a new version.

use serde::{Deserialize, Serialize};

/// Increment of the counter (Steele, Lea, Flood 2014, "Fast splittable pseudorandom number
/// generators").
const GOLDEN_GAMMA: u64 = 0x9e37_79b9_7f4a_7c15;

/// SplitMix64 generator. Its state is one number, which a checkpoint stores.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct SplitMix64(u64);

impl SplitMix64 {
    /// Returns the stream with a name: a list of numbers such as condition, seed and island.
    #[must_use]
    pub fn stream(name: &[u64]) -> Self {
        Self(
            name.iter()
                .fold(0, |state, part| Self(state ^ part).next_u64()),
        )
    }

    /// 64 random bits.
    pub fn next_u64(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(GOLDEN_GAMMA);
        let z = (self.0 ^ self.0 >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ z >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ z >> 31
    }

    /// Returns 128 random bits; the high half is drawn first.
    pub fn next_u128(&mut self) -> u128 {
        let high = u128::from(self.next_u64());
        high << 64 | u128::from(self.next_u64())
    }

    /// Returns a uniform value in [0, 1) from the top 53 bits.
    pub fn unit(&mut self) -> f64 {
        (self.next_u64() >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// Returns a uniform value in 0..n, for n small against 2⁵³.
    pub fn below(&mut self, n: usize) -> usize {
        (self.unit() * n as f64) as usize
    }

    /// Draws an event with this probability; one draw, equal to `unit() < probability`.
    pub fn happens(&mut self, probability: Probability) -> bool {
        self.next_u64() >> 11 < probability.0
    }
}

/// A probability in units of 2⁻⁵³, so that a draw compares integers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Probability(u64);

impl Probability {
    /// Returns `None` unless the value is from 0 to 1.
    #[must_use]
    pub fn new(value: f64) -> Option<Self> {
        (0.0..=1.0)
            .contains(&value)
            .then(|| Self((value * (1_u64 << 53) as f64).ceil() as u64))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn outputs_match_reference_splitmix64() {
        // First outputs for state 1234567, from the reference implementation (Vigna, splitmix64.c).
        let mut rng = SplitMix64(1_234_567);
        let first: Vec<u64> = (0..3).map(|_| rng.next_u64()).collect();
        assert_eq!(
            first,
            [
                6_457_827_717_110_365_317,
                3_203_168_211_198_807_973,
                9_817_491_932_198_370_423
            ]
        );
    }

    #[test]
    fn happens_is_unit_below_probability() {
        for value in [0.0, 1e-17, 0.01, 0.5, 1.0] {
            let probability = Probability::new(value).expect("a probability");
            let (mut a, mut b) = (SplitMix64(9), SplitMix64(9));
            assert!(
                (0..10_000).all(|_| a.happens(probability) == (b.unit() < value)),
                "probability {value}"
            );
        }
        assert_eq!(
            [f64::NAN, -0.1, 1.1, f64::INFINITY].map(Probability::new),
            [None; 4]
        );
    }

    #[test]
    fn streams_differ_per_name_part() {
        let first = |name: &[u64]| SplitMix64::stream(name).next_u64();
        let values = [
            first(&[1, 1, 0]),
            first(&[1, 2, 0]),
            first(&[2, 1, 0]),
            first(&[1, 1, 1]),
            first(&[0, 0, 0]),
        ];
        for (i, a) in values.iter().enumerate() {
            assert!(!values[..i].contains(a), "stream {i}");
        }
    }
}
