//! Selection of trials that show the two cases of paper Fig. 17.

use std::fmt;

use super::facts::TrialFacts;

/// A case: division of four agents into carriers and others (paper III.c.2).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Case {
    /// Two agents carry, the other two avoid.
    TwoCarry,
    /// Three agents carry, one avoids.
    ThreeCarry,
}

impl Case {
    /// Both cases in the order of the paper.
    pub const ALL: [Self; 2] = [Self::TwoCarry, Self::ThreeCarry];

    /// Returns the number in the paper.
    #[must_use]
    pub fn number(self) -> usize {
        self.carriers() - 1
    }

    fn carriers(self) -> usize {
        match self {
            Self::TwoCarry => 2,
            Self::ThreeCarry => 3,
        }
    }
}

impl fmt::Display for Case {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::TwoCarry => "case 1: two carry, two avoid",
            Self::ThreeCarry => "case 2: three carry, one avoids",
        })
    }
}

/// Returns the four-agent trials that show a case, the clearest first: least contact of the other
/// agents with the object, then earliest arrival.
#[must_use]
pub fn examples(case: Case, trials: &[TrialFacts]) -> Vec<TrialFacts> {
    let shows = |trial: &&TrialFacts| {
        trial.agents == 4 && trial.delivered && trial.pushers() == case.carriers()
    };
    let mut found: Vec<TrialFacts> = trials.iter().filter(shows).copied().collect();
    found.sort_by_key(|trial| {
        (
            trial.interference(),
            trial.reached_frame,
            trial.seed,
            trial.goal,
        )
    });
    found
}

#[cfg(test)]
mod tests {
    use super::super::facts::AgentFacts;
    use super::*;

    fn trial(seed: u64, delivered: bool, pushing_frames: [usize; 4]) -> TrialFacts {
        TrialFacts {
            agents: 4,
            seed,
            goal: 1,
            points: 100.0,
            delivered,
            reached_frame: 100,
            distance_px: 5.0,
            each: pushing_frames.map(|pushing_frames| AgentFacts {
                pushing_frames,
                ..AgentFacts::default()
            }),
        }
    }

    #[test]
    fn cases_are_classified_clearest_first() {
        let trials = [
            trial(1, true, [50, 8, 50, 0]),
            trial(2, true, [50, 0, 0, 50]),
            trial(3, true, [50, 50, 0, 50]),
            trial(4, true, [50, 50, 50, 50]),
            trial(5, false, [50, 0, 0, 50]),
        ];
        let seeds = |case| {
            examples(case, &trials)
                .iter()
                .map(|t| t.seed)
                .collect::<Vec<_>>()
        };
        assert_eq!(seeds(Case::TwoCarry), [2, 1]);
        assert_eq!(seeds(Case::ThreeCarry), [3]);
    }
}
