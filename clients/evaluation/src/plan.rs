//! What to evaluate: data, and how it is dealt into trials.

use atas_core::Settings;
use sim_backend::Object;

use crate::condition::Condition;
use crate::policy::GripPolicy;
use crate::task::Task;

/// What to evaluate.
#[derive(Clone, Debug)]
pub struct Plan {
    /// The task.
    pub task: Task,
    /// The nominal objects, or caps; each is the middle of a family.
    pub objects: Vec<Object>,
    /// Trials under each condition, dealt to the objects in turn.
    pub trials: u64,
    /// Number of the first trial of each object: other numbers are other members of the families.
    pub first_seed: u64,
    /// Under which conditions; the first is the one that the report is about, the others are its rows.
    pub conditions: Vec<Condition>,
    /// What to compare with, under the first condition.
    pub baselines: Vec<GripPolicy>,
    /// Threads; 0 for one per core.
    pub threads: usize,
    /// The controller's settings.
    pub settings: Settings,
}

/// One trial of a plan.
#[derive(Clone, Debug)]
pub(crate) struct Job {
    /// Index of the object.
    pub(crate) object: usize,
    /// Number of the trial among those of its object.
    pub(crate) number: u64,
    /// What governs the grip.
    pub(crate) law: GripPolicy,
    /// Under which condition.
    pub(crate) condition: Condition,
}

impl Plan {
    /// How many trials it has, with all conditions and baselines.
    #[must_use]
    pub fn jobs(&self) -> u64 {
        self.trials * self.series().len() as u64
    }

    /// Every law with its condition: ours under all of them, then the baselines under the first.
    pub(crate) fn series(&self) -> Vec<(GripPolicy, Condition)> {
        let ours = self
            .conditions
            .iter()
            .map(|c| (GripPolicy::Ours, c.clone()));
        let first = self.conditions.first();
        let baselines = first.map(|c| self.baselines.iter().map(|law| (*law, c.clone())));
        ours.chain(baselines.into_iter().flatten()).collect()
    }

    /// Trial by trial, so that progress is even although some series take longer.
    pub(crate) fn deal(&self) -> Vec<Job> {
        let objects = self.objects.len();
        let series = self.series();
        let trial = |k: u64| {
            let object = (k % objects as u64) as usize;
            let number = self.first_seed + k / objects as u64;
            series.iter().map(move |(law, condition)| Job {
                object,
                number,
                law: *law,
                condition: condition.clone(),
            })
        };
        (0..self.trials).flat_map(trial).collect()
    }
}
