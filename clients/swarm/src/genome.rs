//! Genotype: a one-dimensional array of bits (paper Fig. 9), with crossover and mutation.

use crate::rng::{Probability, SplitMix64};

const WORD: usize = u128::BITS as usize;

/// Genotype array. Bit g is in word g / 128, lowest bit first; bits beyond the length are zero.
///
/// ```
/// use ebts::genome::Genome;
///
/// let mut genome = Genome::zero(128);
/// genome.set(5, true);
/// let text = genome.to_hex();
/// assert_eq!(Genome::from_hex(128, &text), Some(genome));
/// ```
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Genome {
    words: Box<[u128]>,
    bits: usize,
}

impl Genome {
    /// Returns a genome with all bits zero.
    #[must_use]
    pub fn zero(bits: usize) -> Self {
        Self {
            words: vec![0; bits.div_ceil(WORD)].into(),
            bits,
        }
    }

    /// Draws every bit uniformly (paper step 1).
    pub fn random(bits: usize, rng: &mut SplitMix64) -> Self {
        let mut genome = Self::zero(bits);
        for word in &mut genome.words {
            *word = rng.next_u128();
        }
        genome.cleared_beyond_length()
    }

    /// Returns the number of bits.
    #[must_use]
    pub fn len(&self) -> usize {
        self.bits
    }

    /// Returns whether the genome has no bits.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.bits == 0
    }

    /// Returns bit `index`; false beyond the length.
    #[must_use]
    pub fn get(&self, index: usize) -> bool {
        self.words
            .get(index / WORD)
            .is_some_and(|word| word >> (index % WORD) & 1 == 1)
    }

    /// Sets bit `index`; ignored beyond the length.
    pub fn set(&mut self, index: usize, value: bool) {
        if index < self.bits {
            let word = &mut self.words[index / WORD];
            *word = *word & !(1 << (index % WORD)) | u128::from(value) << (index % WORD);
        }
    }

    /// Returns `count` ≤ 32 bits from `first` on, the first lowest.
    #[must_use]
    pub fn field(&self, first: usize, count: usize) -> u32 {
        (0..count).fold(0, |value, k| value | u32::from(self.get(first + k)) << k)
    }

    /// Returns the bits in words of 128, the first bit lowest.
    #[must_use]
    pub fn words(&self) -> &[u128] {
        &self.words
    }

    /// Uniform crossover (paper step 5): a random mask selects the parent of each bit; the second
    /// child is complementary.
    pub fn crossover(&self, other: &Self, rng: &mut SplitMix64) -> [Self; 2] {
        let mut children = [self.clone(), other.clone()];
        for (word, (a, b)) in self.words.iter().zip(&other.words).enumerate() {
            let mask = rng.next_u128();
            children[0].words[word] = a & mask | b & !mask;
            children[1].words[word] = b & mask | a & !mask;
        }
        children
    }

    /// Flips every bit with this probability (paper step 6).
    pub fn mutate(&mut self, rate: Probability, rng: &mut SplitMix64) {
        for (index, word) in self.words.iter_mut().enumerate() {
            let mut flips = 0;
            for bit in 0..WORD.min(self.bits - index * WORD) {
                flips |= u128::from(rng.happens(rate)) << bit;
            }
            *word ^= flips;
        }
    }

    /// Returns the bits in hexadecimal, 32 digits per word, word 0 first.
    #[must_use]
    pub fn to_hex(&self) -> String {
        self.words
            .iter()
            .map(|word| format!("{word:032x}"))
            .collect()
    }

    /// Parses the output of [`Genome::to_hex`]; `None` if the text is not a genome of this number
    /// of bits.
    #[must_use]
    pub fn from_hex(bits: usize, text: &str) -> Option<Self> {
        let mut genome = Self::zero(bits);
        let digits = text.as_bytes().chunks_exact(WORD / 4);
        if text.len() != genome.words.len() * WORD / 4
            || !text.bytes().all(|b| b.is_ascii_hexdigit())
        {
            return None;
        }
        for (word, digits) in genome.words.iter_mut().zip(digits) {
            *word = u128::from_str_radix(std::str::from_utf8(digits).ok()?, 16).ok()?;
        }
        let cleared = genome.clone().cleared_beyond_length();
        (cleared == genome).then_some(genome)
    }

    fn cleared_beyond_length(mut self) -> Self {
        if let (Some(last), used @ 1..) = (self.words.last_mut(), self.bits % WORD) {
            *last &= (1 << used) - 1;
        }
        self
    }
}

/// Returns the share of differing bits, averaged over all pairs of genomes. Per bit, a set and b
/// unset values make a·b differing pairs. 0 for fewer than two genomes.
#[must_use]
pub fn diversity(genomes: &[&Genome]) -> f64 {
    let (count, bits) = (
        genomes.len(),
        genomes.first().map_or(0, |genome| genome.len()),
    );
    let differing = |bit: usize| {
        let set = genomes.iter().filter(|genome| genome.get(bit)).count();
        set * (count - set)
    };
    let pairs = count * count.saturating_sub(1) / 2 * bits;
    (0..bits).map(differing).sum::<usize>() as f64 / pairs.max(1) as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hex_round_trips_and_rejects_invalid_text() {
        let mut rng = SplitMix64::stream(&[1]);
        for bits in [4, 64, 127, 128, 129, 512] {
            let genome = Genome::random(bits, &mut rng);
            assert_eq!(
                Genome::from_hex(bits, &genome.to_hex()),
                Some(genome),
                "{bits} bits"
            );
        }
        for text in [
            "",
            "0",
            &"g".repeat(32),
            &"+".repeat(32),
            &"0".repeat(64),
            &"f".repeat(31),
        ] {
            assert_eq!(Genome::from_hex(128, text), None, "{text:?}");
        }
        assert_eq!(
            Genome::from_hex(4, &"f".repeat(32)),
            None,
            "bits beyond the length"
        );
    }

    #[test]
    fn diversity_is_the_share_of_differing_bits() {
        let genome =
            |digits: &str| Genome::from_hex(4, &format!("{digits:0>32}")).expect("a genome");
        for (digits, expected) in [
            (&["0"][..], 0.0),
            (&[], 0.0),
            (&["5", "5"], 0.0),
            (&["0", "f"], 1.0),
            (&["0", "1"], 0.25),
            (&["0", "0", "f"], 2.0 / 3.0),
        ] {
            let genomes: Vec<Genome> = digits.iter().map(|digits| genome(digits)).collect();
            assert_eq!(
                diversity(&genomes.iter().collect::<Vec<_>>()),
                expected,
                "{digits:?}"
            );
        }
    }

    #[test]
    fn crossover_distributes_parent_bits_to_both_children() {
        let mut rng = SplitMix64::stream(&[2]);
        let (a, b) = (Genome::random(300, &mut rng), Genome::random(300, &mut rng));
        let [c, d] = a.crossover(&b, &mut rng);
        for k in 0..300 {
            let (mut parents, mut children) = ([a.get(k), b.get(k)], [c.get(k), d.get(k)]);
            parents.sort_unstable();
            children.sort_unstable();
            assert_eq!(parents, children, "bit {k}");
        }
        assert!(c != a && c != b);
    }

    #[test]
    fn mutation_respects_rate_and_length() {
        let mut rng = SplitMix64::stream(&[3]);
        let rate = Probability::new(0.01).expect("a probability");
        let mut flipped = 0;
        for _ in 0..1000 {
            let mut genome = Genome::zero(130);
            genome.mutate(rate, &mut rng);
            flipped += (0..256).filter(|&k| genome.get(k)).count();
            assert_eq!(genome.clone().cleared_beyond_length(), genome);
        }
        assert!((1100..1500).contains(&flipped), "{flipped} of 130 000 bits");
    }
}
