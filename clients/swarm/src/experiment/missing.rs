//! Missing runs of a plan, as text.

use std::collections::HashSet;
use std::fmt;
use std::ops::RangeInclusive;

use super::plan::{Plan, Shard};
use crate::run::Job;

/// Largest number of shards or seed ranges that are listed; further ones are only counted.
const LISTED_MAX: usize = 12;

/// Missing runs of a plan: listed as shards, or else by team size and seed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Missing {
    jobs: Vec<Job>,
    total: usize,
    shards: Vec<Shard>,
}

impl Missing {
    /// Collects the runs for which `has` is false. `folders` is the possible number of merged
    /// shards.
    pub(super) fn new(
        plan: &Plan,
        folders: RangeInclusive<usize>,
        has: impl Fn(&Job) -> bool,
    ) -> Self {
        let all = plan.jobs();
        let positions: Vec<usize> = (0..all.len()).filter(|&at| !has(&all[at])).collect();
        Self {
            shards: whole_shards(&positions, all.len(), &folders),
            jobs: positions.iter().map(|&at| all[at]).collect(),
            total: all.len(),
        }
    }

    /// Returns whether nothing is missing.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.jobs.is_empty()
    }

    /// Formats runs of one team size with consecutive seeds as ranges.
    fn seed_ranges(&self) -> Vec<String> {
        let follows = |a: &Job, b: &Job| (a.agents, a.seed + 1) == (b.agents, b.seed);
        let name = |runs: &[Job]| match runs {
            [] => String::new(),
            [Job { agents, seed }] => format!("agents {agents} seed {seed}"),
            [Job { agents, seed }, .., last] => {
                format!("agents {agents} seeds {seed} to {}", last.seed)
            }
        };
        self.jobs.chunk_by(follows).map(name).collect()
    }
}

/// Returns the shards that contain exactly the runs at these positions, if the number of other
/// shards is in `folders`. Uses the smallest possible shard count; empty if there is none.
fn whole_shards(positions: &[usize], all: usize, folders: &RangeInclusive<usize>) -> Vec<Shard> {
    let Some(&first) = positions.first() else {
        return Vec::new();
    };
    let missing: HashSet<usize> = positions.iter().copied().collect();
    let whole = |at: usize, count: usize| (at..all).step_by(count).all(|at| missing.contains(&at));
    let parts = |count: usize| {
        let firsts = &positions[..positions.partition_point(|&at| at < count)];
        let there = count - firsts.len();
        let runs = |&at: &usize| (at..all).step_by(count).len();
        let are_all = folders.contains(&there)
            && firsts.iter().map(runs).sum::<usize>() == positions.len()
            && firsts.iter().all(|&at| whole(at, count));
        are_all.then_some((count, firsts))
    };
    let found = (first + 1..=folders.end() + positions.len()).find_map(parts);
    found.map_or_else(Vec::new, |(count, firsts)| {
        let shard = |at: &usize| Shard {
            index: at + 1,
            count,
        };
        firsts.iter().map(shard).collect()
    })
}

/// Formats as `shards 2/4, 3/4 (6 of 12 runs)` or
/// `3 of 12 runs (agents 1 seed 2, agents 4 seeds 1 to 2)`.
impl fmt::Display for Missing {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let runs = format!("{} of {} runs", self.jobs.len(), self.total);
        let mut names: Vec<String> = match self.shards.as_slice() {
            [] => self.seed_ranges(),
            shards => shards.iter().map(ToString::to_string).collect(),
        };
        let others = names.len().saturating_sub(LISTED_MAX);
        names.truncate(LISTED_MAX);
        let mut names = names.join(", ");
        if others > 0 {
            names += &format!(" and {others} more");
        }
        match self.shards.len() {
            0 => write!(f, "{runs} ({names})"),
            1 => write!(f, "shard {names} ({runs})"),
            _ => write!(f, "shards {names} ({runs})"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use field::{FitnessRule, Preset};

    fn missing_text(shards: usize, missing: &[usize]) -> String {
        let plan = Plan::fig14(Preset::R3, FitnessRule::AntiAccident, 3, 1);
        let jobs = plan.jobs();
        let gone: Vec<Job> = missing.iter().map(|&at| jobs[at]).collect();
        Missing::new(&plan, shards..=shards, |job| !gone.contains(job)).to_string()
    }

    #[test]
    fn whole_shards_are_named_by_their_number() {
        assert_eq!(missing_text(2, &[1, 4, 7, 10]), "shard 2/3 (4 of 12 runs)");
        assert_eq!(
            missing_text(2, &[1, 2, 5, 6, 9, 10]),
            "shards 2/4, 3/4 (6 of 12 runs)"
        );
        assert_eq!(missing_text(11, &[6]), "shard 7/12 (1 of 12 runs)");
    }

    #[test]
    fn other_runs_are_listed_by_team_size_and_seed() {
        // Two folders cannot hold eleven of twelve shards.
        assert_eq!(missing_text(2, &[6]), "1 of 12 runs (agents 3 seed 1)");
        assert_eq!(
            missing_text(2, &[1, 9, 10]),
            "3 of 12 runs (agents 1 seed 2, agents 4 seeds 1 to 2)"
        );
    }

    #[test]
    fn long_lists_are_truncated() {
        let plan = Plan::fig14(Preset::R3, FitnessRule::AntiAccident, 100, 1);
        let odd = Missing::new(&plan, 1..=1, |job| job.seed % 2 == 0 || job.agents < 4);
        let text = odd.to_string();
        assert!(
            text.starts_with("50 of 400 runs (agents 4 seed 1,"),
            "{text}"
        );
        assert!(text.ends_with("agents 4 seed 23 and 38 more)"), "{text}");
    }
}
