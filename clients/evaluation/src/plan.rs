//! What to evaluate: data, and how it is dealt into trials.

use atas_core::Settings;
use robot_model::RobotFiles;
use sim_backend::Object;

use crate::condition::Condition;
use crate::policy::GripPolicy;
use crate::task::Task;

/// What to evaluate.
#[derive(Clone, Debug)]
pub struct Plan {
    /// The robot.
    pub robot: RobotFiles,
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
    /// What to compare with.
    pub baselines: Vec<GripPolicy>,
    /// Whether the baselines are tried under every condition, and not only under the first.
    pub compare_everywhere: bool,
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

    /// Every law with its condition: ours under all of them, then each baseline.
    pub(crate) fn series(&self) -> Vec<(GripPolicy, Condition)> {
        let compared = match self.compare_everywhere {
            true => self.conditions.len(),
            false => 1.min(self.conditions.len()),
        };
        let under = |law: GripPolicy, conditions: &[Condition]| {
            let conditions = conditions.iter().cloned();
            conditions.map(move |c| (law, c)).collect::<Vec<_>>()
        };
        let ours = under(GripPolicy::Ours, &self.conditions);
        let baselines = self.baselines.iter();
        let baselines = baselines.flat_map(|law| under(*law, &self.conditions[..compared]));
        ours.into_iter().chain(baselines).collect()
    }

    /// Trials of each object, rounded up.
    #[must_use]
    pub fn seeds(&self) -> u64 {
        self.trials.div_ceil(self.objects.len().max(1) as u64)
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
