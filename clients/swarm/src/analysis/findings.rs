//! Findings of the paper (III.c), each with an estimate, an interval and a verdict.

use std::fmt;

use rayon::prelude::*;
use serde::Serialize;

use field::FitnessRule;

use super::facts::{TrialFacts, facts};
use crate::condition::Condition;
use crate::error::Result;
use crate::experiment::Plan;
use crate::run::Record;
use crate::stats::{Estimate, bootstrap, median, p_greater};

/// Findings of one experiment; `None` without runs of the required team sizes.
#[derive(Clone, Debug, Serialize)]
pub struct Findings {
    /// Name of the preset.
    pub preset: String,
    /// Scoring of the runs.
    pub fitness_rule: FitnessRule,
    /// The smallest median of several agents over the median of one (paper: more than five times).
    pub ratio: Option<Estimate>,
    /// Probabilities of the paper's orderings between two runs.
    pub order: Order,
    /// Behaviour of single agents.
    pub single: Option<Single>,
    /// Behaviour of four agents.
    pub redundancy: Option<Redundancy>,
}

/// Probabilities that one random run exceeds another; ties count half.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Order {
    /// A run with three agents exceeds one with four (paper III.c.1).
    pub three_gt_four: Option<Estimate>,
    /// A run with two agents exceeds one with four.
    pub two_gt_four: Option<Estimate>,
    /// A run with three agents exceeds one with two ("three agents are optimum").
    pub three_gt_two: Option<Estimate>,
    /// A run with several agents reaches five times a run with one.
    pub multi_ge_5x_single: Option<Estimate>,
}

/// Single agents over all their trials (paper Fig. 15).
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Single {
    /// Solved trials per run, of eight.
    pub solved_per_run: f64,
    /// Trials in which the agent circles.
    pub circling: Estimate,
    /// Trials in which the agent circles, stands still or ends beside the object.
    pub trapped: Estimate,
}

/// Solved trials of four agents (paper Fig. 17).
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Redundancy {
    /// Solved trials of all runs: the object delivered, independent of the fitness rule.
    pub solved: usize,
    /// Number of trials solved by 0, 1, 2, 3 and 4 pushing agents.
    pub by_pushers: [usize; 5],
    /// Share of solved trials in which two or three agents pushed and the others kept out.
    pub keep_out: Estimate,
}

/// Verdict on a finding at the 95 % level.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Verdict {
    /// The whole interval is above the border.
    Reproduces,
    /// The whole interval is below the border.
    DoesNotReproduce,
    /// The interval contains the border.
    Undecided,
}

impl Verdict {
    /// Compares an interval with a border.
    #[must_use]
    pub fn above(border: f64, Estimate { low, high, .. }: Estimate) -> Self {
        match (low > border, high < border) {
            (true, _) => Self::Reproduces,
            (_, true) => Self::DoesNotReproduce,
            _ => Self::Undecided,
        }
    }
}

impl fmt::Display for Verdict {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Reproduces => "yes",
            Self::DoesNotReproduce => "NO",
            Self::Undecided => "undecided",
        })
    }
}

#[derive(Clone, Copy, Default)]
struct Trials {
    trials: usize,
    solved: usize,
    circling: usize,
    trapped: usize,
    by_pushers: [usize; 5],
}

impl Trials {
    fn add(&mut self, trial: &TrialFacts) {
        let first = trial.each[0];
        self.trials += 1;
        self.circling += usize::from(first.circling);
        self.trapped += usize::from(first.trapped);
        if trial.delivered {
            self.solved += 1;
            self.by_pushers[trial.pushers()] += 1;
        }
    }
}

/// Analyses the finished runs of a Fig. 14 experiment.
pub fn findings(plan: &Plan, records: &[Record]) -> Result<Findings> {
    let conditions = plan.conditions()?;
    let fitness = |agents: usize| -> Vec<f32> {
        let of_team = records.iter().filter(|record| record.agents == agents);
        of_team.map(Record::fitness).collect()
    };
    let groups = [1, 2, 3, 4].map(fitness);
    let [one, two, three, four] = &groups;
    let greater = |a: &[f32], b: &[f32]| {
        let both = !a.is_empty() && !b.is_empty();
        both.then(|| bootstrap(&[a, b], |groups| p_greater(&groups[0], &groups[1])))
    };
    let several = [two, three, four]
        .into_iter()
        .filter(|group| !group.is_empty());
    let all: Vec<&[f32]> = std::iter::once(one)
        .chain(several)
        .map(Vec::as_slice)
        .collect();
    let comparable = !one.is_empty() && all.len() > 1;
    Ok(Findings {
        preset: plan.preset.name.to_string(),
        fitness_rule: plan.fitness_rule,
        ratio: comparable.then(|| bootstrap(&all, ratio)),
        order: Order {
            three_gt_four: greater(three, four),
            two_gt_four: greater(two, four),
            three_gt_two: greater(three, two),
            multi_ge_5x_single: comparable.then(|| bootstrap(&all, multi_ge_5x_single)),
        },
        single: single(&trials_of(&conditions, records, 1)),
        redundancy: redundancy(&trials_of(&conditions, records, 4)),
    })
}

fn ratio(groups: &[Vec<f32>]) -> f64 {
    let smallest = groups[1..]
        .iter()
        .map(|group| median(group))
        .fold(f32::MAX, f32::min);
    f64::from(smallest / median(&groups[0]).max(1.0))
}

/// Returns the probability that a random multi-agent run reaches five times a random single-agent
/// run.
fn multi_ge_5x_single(groups: &[Vec<f32>]) -> f64 {
    let five_times: Vec<f32> = groups[0].iter().map(|fitness| 5.0 * fitness).collect();
    groups[1..]
        .iter()
        .map(|group| p_greater(group, &five_times))
        .sum::<f64>()
        / (groups.len() - 1) as f64
}

fn trials_of(conditions: &[Condition], records: &[Record], agents: usize) -> Vec<Trials> {
    let Some(condition) = conditions
        .iter()
        .find(|condition| condition.team.get() == agents)
    else {
        return Vec::new();
    };
    records
        .par_iter()
        .filter(|record| record.agents == agents)
        .map(|record| trials(condition, record))
        .collect()
}

fn trials(condition: &Condition, record: &Record) -> Trials {
    let mut sum = Trials::default();
    for trial in facts(condition, record) {
        sum.add(&trial);
    }
    sum
}

fn share(
    runs: &[Trials],
    part: impl Fn(&Trials) -> usize,
    whole: impl Fn(&Trials) -> usize,
) -> Estimate {
    bootstrap(&[runs], |groups| {
        let count = |of: &dyn Fn(&Trials) -> usize| groups[0].iter().map(of).sum::<usize>() as f64;
        count(&part) / count(&whole).max(1.0)
    })
}

fn single(runs: &[Trials]) -> Option<Single> {
    let solved: usize = runs.iter().map(|run| run.solved).sum();
    (!runs.is_empty()).then(|| Single {
        solved_per_run: solved as f64 / runs.len() as f64,
        circling: share(runs, |run| run.circling, |run| run.trials),
        trapped: share(runs, |run| run.trapped, |run| run.trials),
    })
}

fn redundancy(runs: &[Trials]) -> Option<Redundancy> {
    (!runs.is_empty()).then(|| Redundancy {
        solved: runs.iter().map(|run| run.solved).sum(),
        by_pushers: std::array::from_fn(|k| runs.iter().map(|run| run.by_pushers[k]).sum()),
        keep_out: share(
            runs,
            |run| run.by_pushers[2] + run.by_pushers[3],
            |run| run.solved,
        ),
    })
}
