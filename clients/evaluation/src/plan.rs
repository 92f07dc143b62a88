//! Plan of an evaluation, and its division into trials and shards.

use std::str::FromStr;

use atas_core::Settings;
use robot_model::RobotFiles;
use serde::{Deserialize, Serialize};
use shm_schemas::layout::{FNV_OFFSET, NamedLayout, fnv1a};
use sim_backend::Object;
use sim_backend::engine::EngineCommand;

use crate::Task;
use crate::condition::Condition;
use crate::policy::GripPolicy;

/// Plan of an evaluation.
#[derive(Clone, Debug)]
pub struct Plan {
    /// The robot.
    pub robot: RobotFiles,
    /// Fingertip layout, if not the robot file's.
    pub skin: Option<NamedLayout>,
    /// The task.
    pub task: Task,
    /// Nominal objects or caps; each is the centre of a family.
    pub objects: Vec<Object>,
    /// Number of trials under each condition, distributed to the objects in turn.
    pub trials: u64,
    /// Number of the first trial of each object. Other numbers give other family members.
    pub first_seed: u64,
    /// Conditions. The report's headline is the first; all of them are its rows.
    pub conditions: Vec<Condition>,
    /// Baselines to compare with.
    pub baselines: Vec<GripPolicy>,
    /// True: baselines run under every condition. False: only under the first.
    pub compare_everywhere: bool,
    /// Physics engine in a process of its own; `None`: the built-in one.
    pub engine: Option<EngineCommand>,
    /// Threads; 0: one per core.
    pub threads: usize,
    /// Controller settings.
    pub settings: Settings,
}

/// Part of an evaluation: shard `number` of `of`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Shard {
    /// Number of the shard, from 1.
    pub number: u64,
    /// Number of shards.
    pub of: u64,
}

impl Shard {
    /// The whole evaluation as one shard.
    pub const WHOLE: Self = Self { number: 1, of: 1 };

    pub(crate) fn contains(self, index: usize) -> bool {
        index as u64 % self.of == self.number - 1
    }
}

impl FromStr for Shard {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let numbers = text.split_once('/').and_then(|(number, of)| {
            let (number, of) = (number.parse().ok()?, of.parse().ok()?);
            (1..=of).contains(&number).then_some(Self { number, of })
        });
        numbers.ok_or_else(|| {
            format!(
                "could not read shard {text:?}: it needs the form I/N with I from 1 to N, for \
                example 2/8"
            )
        })
    }
}

#[derive(Clone, Debug)]
pub(crate) struct Job {
    pub(crate) object: usize,
    pub(crate) number: u64,
    pub(crate) policy: GripPolicy,
    pub(crate) condition: Condition,
}

impl Plan {
    /// Returns the number of trials over all conditions and baselines.
    #[must_use]
    pub fn jobs(&self) -> u64 {
        self.trials * self.series().len() as u64
    }

    /// Returns a hash of all that determines the trials.
    #[must_use]
    pub fn hash(&self) -> u64 {
        let decisive = Self {
            threads: 0,
            ..self.clone()
        };
        let text = format!("{} {decisive:?}", env!("CARGO_PKG_VERSION"));
        fnv1a(FNV_OFFSET, text.as_bytes())
    }

    /// Returns the number of trials of one shard.
    #[must_use]
    pub fn jobs_of(&self, shard: Shard) -> u64 {
        (0..self.jobs() as usize)
            .filter(|&index| shard.contains(index))
            .count() as u64
    }

    /// Returns each policy with its condition: the ATAS modules under all conditions, then each
    /// baseline.
    pub(crate) fn series(&self) -> Vec<(GripPolicy, Condition)> {
        let compared = match self.compare_everywhere {
            true => self.conditions.len(),
            false => 1.min(self.conditions.len()),
        };
        let under = |policy: GripPolicy, conditions: &[Condition]| {
            let conditions = conditions.iter().cloned();
            conditions.map(move |c| (policy, c)).collect::<Vec<_>>()
        };
        let ours = under(GripPolicy::BuiltIn, &self.conditions);
        let baselines = self.baselines.iter();
        let baselines = baselines.flat_map(|policy| under(*policy, &self.conditions[..compared]));
        ours.into_iter().chain(baselines).collect()
    }

    /// Returns the trials per object, rounded up.
    #[must_use]
    pub fn seeds(&self) -> u64 {
        self.trials.div_ceil(self.objects.len().max(1) as u64)
    }

    /// Lists the jobs trial by trial, all series within a trial. Progress stays even although some
    /// series are slower.
    pub(crate) fn deal(&self) -> Vec<Job> {
        let objects = self.objects.len();
        let series = self.series();
        let trial = |k: u64| {
            let object = (k % objects as u64) as usize;
            let number = self.first_seed + k / objects as u64;
            series.iter().map(move |(policy, condition)| Job {
                object,
                number,
                policy: *policy,
                condition: condition.clone(),
            })
        };
        (0..self.trials).flat_map(trial).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shards_partition_all_trials() {
        let check = |text: &str, expected: Option<(u64, u64)>| {
            let shard = text.parse::<Shard>().ok();
            assert_eq!(shard.map(|s| (s.number, s.of)), expected, "{text}");
        };
        check("2/8", Some((2, 8)));
        check("1/1", Some((1, 1)));
        for wrong in ["", "0/8", "9/8", "1/0", "2", "a/b", "1/2/3", "-1/2"] {
            check(wrong, None);
        }
        for index in 0..20 {
            let owners = (1..=3).filter(|&number| Shard { number, of: 3 }.contains(index));
            assert_eq!(owners.count(), 1);
        }
    }
}
