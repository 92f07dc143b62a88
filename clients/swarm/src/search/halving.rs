//! Stages of a search: all candidates on few seeds, then fewer on more.

use std::ops::Range;

use serde::Serialize;

use crate::error::{Error, Result};

/// How much fewer candidates and how many more seeds the next stage has (ours: halving by three loses good candidates less
/// often than by two with the same effort spent on the last ones).
const FACTOR: u64 = 3;

/// What a search may spend.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Halving {
    /// Candidates of the first stage.
    pub candidates: usize,
    /// Candidates that the last stage leaves.
    pub best: usize,
    /// Seeds of the first stage.
    pub seeds: u64,
    /// The first of them; further stages go on where the one before ended.
    pub first_seed: u64,
    /// Seeds of the verdict.
    pub verdict_seeds: u64,
    /// The first of them.
    pub verdict_first_seed: u64,
}

/// So many candidates on these seeds, which no other stage has.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Stage {
    /// From 1.
    pub number: usize,
    /// How many candidates.
    pub candidates: usize,
    /// Their first seed in this stage.
    pub first_seed: u64,
    /// Runs per team size in this stage; what was run before counts as well.
    pub seeds: u64,
}

impl Halving {
    /// The stages, the last of which has the best.
    #[must_use]
    pub fn stages(&self) -> Vec<Stage> {
        let mut stages = Vec::new();
        let (mut candidates, mut seeds, mut first_seed) =
            (self.candidates, self.seeds, self.first_seed);
        loop {
            stages.push(Stage {
                number: stages.len() + 1,
                candidates,
                first_seed,
                seeds,
            });
            if candidates <= self.best {
                return stages;
            }
            first_seed = first_seed.saturating_add(seeds);
            candidates = candidates.div_ceil(FACTOR as usize).max(self.best);
            seeds = seeds.saturating_mul(FACTOR - 1);
        }
    }

    /// Refuses numbers that make no search, and a verdict on seeds that something was chosen with.
    ///
    /// # Errors
    /// The first number that is out of range.
    pub fn check(&self) -> Result<()> {
        let refuse = |what: String, needs: String, cure: &str| {
            Err(Error::refused("search", what, needs, cure))
        };
        if !(1..=100_000).contains(&self.candidates) || !(1..=self.candidates).contains(&self.best)
        {
            return refuse(
                format!(
                    "there were {} candidates to leave {}",
                    self.candidates, self.best
                ),
                "1 to 100000 candidates, of which 1 or more are left".to_owned(),
                "correct --candidates or --best",
            );
        }
        let (tuning, verdict) = (self.tuning(), self.verdict());
        if tuning.start < verdict.end && verdict.start < tuning.end {
            return refuse(
                format!("the verdict had seeds from {} on", verdict.start),
                format!(
                    "seeds outside {} to {}, which choose",
                    tuning.start,
                    tuning.end - 1
                ),
                "correct --verdict-first-seed",
            );
        }
        Ok(())
    }

    /// Seeds that something is chosen with.
    #[must_use]
    pub fn tuning(&self) -> Range<u64> {
        let end = self.stages().last().map_or(self.first_seed, |last| {
            last.first_seed.saturating_add(last.seeds)
        });
        self.first_seed..end
    }

    /// Seeds of the verdict.
    #[must_use]
    pub fn verdict(&self) -> Range<u64> {
        self.verdict_first_seed..self.verdict_first_seed.saturating_add(self.verdict_seeds)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const HALVING: Halving = Halving {
        candidates: 100,
        best: 3,
        seeds: 8,
        first_seed: 1000,
        verdict_seeds: 80,
        verdict_first_seed: 1,
    };

    #[test]
    fn stages_have_fewer_candidates_and_more_seeds_and_share_none() {
        let stages = HALVING.stages();
        let rows: Vec<_> = stages
            .iter()
            .map(|s| (s.candidates, s.first_seed, s.seeds))
            .collect();
        let expected = [
            (100, 1000, 8),
            (34, 1008, 16),
            (12, 1024, 32),
            (4, 1056, 64),
            (3, 1120, 128),
        ];
        assert_eq!(rows, expected);
        assert_eq!(HALVING.tuning(), 1000..1248);
    }

    #[test]
    fn the_verdict_has_seeds_of_its_own() {
        assert!(HALVING.check().is_ok());
        for verdict_first_seed in [921, 1000, 1100, 1247] {
            let halving = Halving {
                verdict_first_seed,
                ..HALVING
            };
            assert!(halving.check().is_err(), "{verdict_first_seed}");
        }
        for (candidates, best) in [(0, 0), (3, 4), (3, 0)] {
            let halving = Halving {
                candidates,
                best,
                ..HALVING
            };
            assert!(halving.check().is_err(), "{candidates} {best}");
        }
    }
}
