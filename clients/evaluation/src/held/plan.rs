//! Objects, seeds and engine of an evaluation that holds one object, and the common part of its
//! report.

use std::collections::BTreeMap;
use std::sync::atomic::AtomicBool;

use atas_core::Settings;
use robot_model::RobotModel;
use serde::Serialize;
use sim_backend::engine::{EngineCommand, EnginePool};
use sim_backend::random::trial_seed;
use sim_backend::{Errors, Object};

use super::{HeldTrial, Outcome};
use crate::parallel::run_indexed;
use crate::seeds;

/// Worlds of an evaluation: each object with each seed.
#[derive(Clone, Debug)]
pub struct HeldPlan {
    /// Nominal objects.
    pub objects: Vec<Object>,
    /// Worlds per object.
    pub seeds: u64,
    /// First seed per object.
    pub first_seed: u64,
    /// Physics engine in a process of its own; `None`: the built-in one.
    pub engine: Option<EngineCommand>,
    /// Threads; 0: one per core.
    pub threads: usize,
    /// Controller settings.
    pub settings: Settings,
}

/// One object and seed of a plan.
pub(crate) struct HeldWorld<'a> {
    plan: &'a HeldPlan,
    robot: &'a RobotModel,
    engines: Option<&'a EnginePool>,
    object: &'a Object,
    pub(crate) seed: u64,
}

/// Objects, seeds and engine of a report.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct HeldSummary {
    /// Physics engine, if not the built-in one.
    pub engine: Option<String>,
    /// Names of the objects.
    pub objects: Vec<String>,
    /// Worlds per object.
    pub seeds: u64,
    /// First seed per object.
    pub first_seed: u64,
    /// `tuning` or `judging`.
    pub purpose: &'static str,
    /// Trials that the engine could not simulate, by reason.
    pub discarded: BTreeMap<String, u64>,
}

/// Counts of trials by outcome.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Outcomes {
    /// Trials.
    pub trials: u64,
    /// Objects in the lifted hand at the end, stable and unharmed.
    pub held: u64,
    /// Crushed objects.
    pub crushed: u64,
    /// Dropped objects.
    pub dropped: u64,
    /// Objects in the lifted hand that slipped or turned beyond the limits of the judge.
    pub slipped: u64,
    /// Objects that were not lifted, or put back.
    pub not_lifted: u64,
    /// Trials that the engine could not simulate: never a success.
    pub discarded: u64,
}

impl HeldPlan {
    /// Returns the number of worlds: one per object and seed.
    #[must_use]
    pub fn worlds(&self) -> u64 {
        self.objects.len() as u64 * self.seeds
    }

    /// Calls `run` for all worlds of each series, from any thread, and `done` after each; `None` if
    /// stopped. The worlds of a series are consecutive in the result, and in these those of an
    /// object.
    ///
    /// # Errors
    /// The robot cannot be created, the plan is empty, or the first error of `run`.
    pub(crate) fn run<T: Send>(
        &self,
        series: usize,
        stop: &AtomicBool,
        done: impl Fn() + Sync,
        run: impl Fn(usize, &HeldWorld<'_>) -> anyhow::Result<T> + Sync,
    ) -> anyhow::Result<Option<Vec<T>>> {
        let (worlds, series) = (self.worlds(), series as u64);
        anyhow::ensure!(
            worlds * series > 0,
            "could not evaluate: the plan has no trial; request at least one object, seed and case"
        );
        let robot = RobotModel::two_hand_arm()?;
        let engines = self.engine.clone().map(EnginePool::new);
        run_indexed(worlds * series, self.threads, stop, |index| {
            let world = index % worlds;
            let object = &self.objects[(world / self.seeds) as usize];
            let number = self.first_seed + world % self.seeds;
            let world = HeldWorld {
                plan: self,
                robot: &robot,
                engines: engines.as_ref(),
                object,
                seed: trial_seed(&object.name, number),
            };
            let result = run((index / worlds) as usize, &world)?;
            done();
            Ok(result)
        })
    }

    /// Returns the common part of the report; `discarded` has the reason of each discarded trial.
    pub(crate) fn summary<'a>(
        &self,
        discarded: impl Iterator<Item = &'a Option<String>>,
    ) -> HeldSummary {
        let mut reasons = BTreeMap::new();
        for reason in discarded.flatten() {
            *reasons.entry(reason.clone()).or_default() += 1;
        }
        HeldSummary {
            engine: self.engine.as_ref().map(ToString::to_string),
            objects: self.objects.iter().map(|o| o.name.clone()).collect(),
            seeds: self.seeds,
            first_seed: self.first_seed,
            purpose: seeds::purpose(self.first_seed, self.seeds),
            discarded: reasons,
        }
    }
}

impl<'a> HeldWorld<'a> {
    /// Prepares a trial with these errors.
    ///
    /// # Errors
    /// As [`HeldTrial::new`].
    pub(crate) fn trial(&self, errors: &Errors) -> anyhow::Result<HeldTrial<'a>> {
        HeldTrial::new(
            self.robot,
            self.engines,
            self.object.clone(),
            self.seed,
            self.plan.settings,
            errors,
        )
    }
}

impl HeldSummary {
    /// Returns the discarded trials as one line per reason; empty without any.
    #[must_use]
    pub fn discards(&self) -> String {
        let line = |(reason, count): (&String, &u64)| {
            format!("discarded by the engine: {count} × {reason}\n")
        };
        self.discarded.iter().map(line).collect()
    }
}

#[cfg(test)]
impl Outcomes {
    /// Returns the sum over all outcomes: the number of trials.
    pub(crate) fn sum(&self) -> u64 {
        let lost = self.crushed + self.dropped + self.slipped + self.not_lifted;
        self.held + lost + self.discarded
    }
}

impl FromIterator<Outcome> for Outcomes {
    fn from_iter<T: IntoIterator<Item = Outcome>>(outcomes: T) -> Self {
        let mut counts = Self::default();
        for outcome in outcomes {
            counts.trials += 1;
            *match outcome {
                Outcome::Held => &mut counts.held,
                Outcome::Crushed => &mut counts.crushed,
                Outcome::Dropped => &mut counts.dropped,
                Outcome::Slipped => &mut counts.slipped,
                Outcome::NotLifted => &mut counts.not_lifted,
                Outcome::Discarded => &mut counts.discarded,
            } += 1;
        }
        counts
    }
}
