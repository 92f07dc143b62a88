//! Disturbances of a held object: added loads, bumps of the arm and lagging servos, for the ATAS
//! modules and the baselines.
//!
//! ```text
//!  object, seed, grip policy ─▶ grasp, lift, hold ─▶ case: load, bump or lag ─▶ outcome, slip,
//!                               latency of the response, force afterwards
//! ```
//!
//! * **In:** objects, seeds, an engine. **Out:** a [`DisturbanceReport`]: one row per case and
//!   policy.
//! * **Invariants:** with the built-in engine, the report depends on the plan only. All policies
//!   and cases of an object and seed have the same world, noise and direction of the load.
//! * **Not included:** contact of the arm with its environment; a bump displaces the fingertips.

mod applied;
mod case;
mod report;
mod response;
mod trial;

use std::sync::atomic::AtomicBool;

use crate::Task;
use crate::held::{Grip, HeldPlan};
use crate::policy::GripPolicy;
use case::{CASES, Disturbance};

pub use report::{DisturbanceReport, DisturbanceRow};

/// Plan of the evaluation.
#[derive(Clone, Debug)]
pub struct DisturbancePlan {
    /// Worlds, each with every case and policy.
    pub held: HeldPlan,
    /// Texts of which one is part of the name of each evaluated case; empty: all cases.
    pub cases: Vec<String>,
    /// True: the baselines of the grasp get the same trials.
    pub baselines: bool,
}

impl DisturbancePlan {
    /// Returns the number of trials.
    #[must_use]
    pub fn trials(&self) -> u64 {
        self.held.worlds() * (self.cases().len() * self.grips().len()) as u64
    }

    /// Runs all trials; calls `done` after each, from any thread; `None` if stopped.
    ///
    /// # Errors
    /// The robot, a world or an engine cannot be created, or the plan is empty.
    pub fn run(
        &self,
        stop: &AtomicBool,
        done: impl Fn() + Sync,
    ) -> anyhow::Result<Option<DisturbanceReport>> {
        let (cases, grips) = (self.cases(), self.grips());
        let series = cases.len() * grips.len();
        let endings = self.held.run(series, stop, done, |series, world| {
            let (case, grip) = (cases[series / grips.len()], grips[series % grips.len()]);
            trial::run(&world.trial(&case.errors())?, case, grip, world.seed)
        })?;
        Ok(endings.map(|endings| DisturbanceReport::new(self, &endings)))
    }

    /// Returns the requested cases.
    fn cases(&self) -> Vec<Disturbance> {
        let is_requested = |case: &Disturbance| {
            let (name, mut texts) = (case.name(), self.cases.iter());
            self.cases.is_empty() || texts.any(|text| name.contains(text.as_str()))
        };
        CASES.into_iter().filter(is_requested).collect()
    }

    /// Returns the grip policies, the ATAS modules first.
    fn grips(&self) -> Vec<Grip> {
        let baselines = GripPolicy::baselines(Task::Grasp, None);
        let baselines = baselines.into_iter().filter(|_| self.baselines);
        let policies = core::iter::once(GripPolicy::BuiltIn).chain(baselines);
        policies.map(Grip::Policy).collect()
    }
}

#[cfg(test)]
mod tests {
    use sim_backend::Object;

    use super::*;
    use crate::seeds;

    fn plan(threads: usize) -> DisturbancePlan {
        DisturbancePlan {
            held: HeldPlan {
                objects: vec![Object::built_in("wood").expect("built in")],
                seeds: 1,
                first_seed: seeds::EVALUATION_START,
                engine: None,
                threads,
                settings: atas_core::Settings::default(),
            },
            cases: Vec::new(),
            baselines: true,
        }
    }

    #[test]
    fn cases_are_selected_by_their_names() {
        let check = |texts: &[&str], expected: usize| {
            let plan = DisturbancePlan {
                cases: texts.iter().map(|text| (*text).to_owned()).collect(),
                ..plan(0)
            };
            assert_eq!(plan.cases().len(), expected, "{texts:?}");
            assert_eq!(plan.trials(), 3 * expected as u64);
        };
        check(&[], CASES.len());
        check(&["bump", "lag"], 3);
        check(&["moon"], 0);
    }

    /// Regression: a grip that closed by 2 mm/s lost the first object, and an upward load counted
    /// as a drop, for which the hand closed to F_2 and put the object back.
    #[test]
    fn sudden_load_of_the_whole_weight_leaves_the_object_in_the_hand() {
        for (object, case) in [
            ("slippery-50", "step 1 × weight down"),
            ("wood", "step 1 × weight up"),
            ("paper-box", "step 1 × weight up"),
        ] {
            let mut plan = DisturbancePlan {
                cases: vec![case.to_owned()],
                baselines: false,
                ..plan(0)
            };
            plan.held.objects = vec![Object::built_in(object).expect("built in")];
            plan.held.seeds = 2;
            let report = plan.run(&AtomicBool::new(false), || ());
            let report = report.expect("it runs").expect("not stopped");
            assert_eq!(report.rows[0].kept, 2, "{object}: {:?}", report.rows[0]);
        }
    }

    /// One rigid object: it is kept without a disturbance; the rows count cases and policies.
    #[test]
    fn report_counts_cases_and_policies() {
        let run = |threads| {
            let plan = DisturbancePlan {
                cases: vec!["none".to_owned(), "bump 5".to_owned()],
                ..plan(threads)
            };
            let report = plan.run(&AtomicBool::new(false), || ());
            report.expect("it runs").expect("not stopped")
        };
        let report = run(0);
        assert_eq!(report.rows.len(), 3 * 2);
        for row in &report.rows {
            let lost = row.crushed + row.dropped + row.put_back + row.not_lifted;
            let sum = row.kept + lost + row.discarded;
            assert_eq!((row.trials, sum), (1, 1), "{row:?}");
        }
        let ours = &report.rows[0];
        assert_eq!(
            (ours.case.as_str(), ours.policy, ours.kept),
            ("none", "ours", 1)
        );
        assert!(
            ours.slip_mm.is_some_and(|[_, most_mm]| most_mm < 0.5),
            "{ours:?}"
        );
        let lines = report.markdown().lines().count();
        assert_eq!(lines, 2 + 2);
        assert_eq!(report, run(1), "independent of the number of threads");
    }
}
