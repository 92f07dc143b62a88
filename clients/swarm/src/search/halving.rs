//! Stages of a search (successive halving): all candidates on few seeds, then fewer candidates on
//! more seeds.

use std::ops::Range;

use serde::Serialize;

use crate::error::{Error, Result};

/// Factor of candidates and seeds between two stages. Design choice: 3 loses good candidates less
/// often than 2 at equal effort for the last ones.
const FACTOR: u64 = 3;

/// Budget of a search.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Halving {
    /// Candidates of the first stage.
    pub candidates: usize,
    /// Candidates that remain after the last stage.
    pub best: usize,
    /// Seeds of the first stage.
    pub seeds: u64,
    /// First seed of the first stage; later stages continue behind the previous one.
    pub first_seed: u64,
    /// Seeds of the verdict.
    pub verdict_seeds: u64,
    /// First seed of the verdict.
    pub verdict_first_seed: u64,
}

/// One stage: a number of candidates on seeds that no other stage uses.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Stage {
    /// Number, from 1.
    pub number: usize,
    /// Number of candidates.
    pub candidates: usize,
    /// First seed of this stage.
    pub first_seed: u64,
    /// Runs per team size in this stage; earlier runs count as well.
    pub seeds: u64,
}

impl Halving {
    /// Returns all stages in order.
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

    /// Validates the numbers; rejects verdict seeds that overlap with the tuning seeds.
    pub fn check(&self) -> Result<()> {
        let refuse = |what: String, needs: String, cure: &str| {
            Err(Error::refused("search", what, needs, cure))
        };
        if !(1..=100_000).contains(&self.candidates) || !(1..=self.candidates).contains(&self.best)
        {
            return refuse(
                format!(
                    "there are {} candidates to leave {}",
                    self.candidates, self.best
                ),
                "1 to 100000 candidates, of which at least 1 remains".to_owned(),
                "correct --candidates or --best",
            );
        }
        let (tuning, verdict) = (self.tuning(), self.verdict());
        if tuning.start < verdict.end && verdict.start < tuning.end {
            return refuse(
                format!("the verdict has seeds from {} on", verdict.start),
                format!(
                    "seeds outside {} to {}, which are used for tuning",
                    tuning.start,
                    tuning.end - 1
                ),
                "correct --verdict-first-seed",
            );
        }
        Ok(())
    }

    /// Returns the seeds used for tuning.
    #[must_use]
    pub fn tuning(&self) -> Range<u64> {
        let end = self.stages().last().map_or(self.first_seed, |last| {
            last.first_seed.saturating_add(last.seeds)
        });
        self.first_seed..end
    }

    /// Returns the seeds of the verdict.
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
    fn stages_reduce_candidates_on_disjoint_seeds() {
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
    fn verdict_seeds_must_not_overlap() {
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
