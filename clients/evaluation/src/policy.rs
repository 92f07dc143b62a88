//! What governs the grip: our modules, or a baseline to beat.
//!
//! A baseline is a task made of the built-in one: the same motions, the same guard, the same Module 4; but where the
//! built-in task has its modules for the grip (stiffness probe, modules 1, 2 and 3, what gives force back and what proves
//! a lift), the baseline has one that knows neither stiffness nor F_2. It runs in the same controller, by the same arms.

use atas_core::Settings;
use atas_core::modules::Selection;
use atas_core::tasks::{self, Name, Step, Task, Track, Transition};
use shm_schemas::{GoalKind, GoalRequest, ModuleId, Text};

/// What the built-in tasks govern the grip with.
const OURS: [ModuleId; 6] = [
    ModuleId::FIRST_TOUCH,
    ModuleId::PROBE,
    ModuleId::SLIP,
    ModuleId::FORCE_LIMIT,
    ModuleId::RELAX,
    ModuleId::LOAD_TEST,
];
/// Share of F_2 that F_1 never exceeds ([`atas_core::thresholds::Thresholds`]).
const F1_BELOW_F2: f64 = 0.8;

/// Force per finger from which the slip-reactive baseline starts, N: the best of 0.35, 0.6 and 1 N over other seeds.
const START_N: f64 = 0.6;

/// A law of the grip.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum GripPolicy {
    /// Modules 1, 2, 3, the stiffness probe and relaxing, as the built-in tasks have them.
    Ours,
    /// A gripper that closes until it presses with this force per finger, N, and keeps it: Module 1 alone, F_1 being the
    /// force.
    FixedForce(f64),
    /// The force rises by 8 % per 41 ms of slip from this force per finger, N, after Romano et al. 2011:
    /// [`ModuleId::SLIP_REACTION`].
    SlipReactive(f64),
}

impl GripPolicy {
    /// The baselines of a task, the first with this force or the best for the task.
    #[must_use]
    pub fn baselines(task: crate::task::Task, force_n: Option<f64>) -> [Self; 2] {
        let force_n = force_n.unwrap_or(task.best_fixed_force_n());
        [Self::FixedForce(force_n), Self::SlipReactive(START_N)]
    }

    /// Its name in reports.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Ours => "ours",
            Self::FixedForce(_) => "fixed_force",
            Self::SlipReactive(_) => "slip_reactive",
        }
    }

    /// The module that governs the grip instead of ours; `None` for ours.
    fn module(self) -> Option<ModuleId> {
        match self {
            Self::Ours => None,
            Self::FixedForce(_) => Some(ModuleId::FIRST_TOUCH),
            Self::SlipReactive(_) => Some(ModuleId::SLIP_REACTION),
        }
    }

    /// The controller's settings under this law.
    #[must_use]
    pub fn settings(self, ours: &Settings) -> Settings {
        let mut settings = *ours;
        if let Self::FixedForce(force_n) | Self::SlipReactive(force_n) = self {
            let grasp = &mut settings.grasp;
            (grasp.f1_min_n, grasp.f1_max_n) = (force_n, force_n);
            (grasp.f2_min_n, grasp.f2_max_n) = (force_n / F1_BELOW_F2, force_n / F1_BELOW_F2);
        }
        settings
    }

    /// The goal under this law: for a baseline, the same with a task of its own.
    #[must_use]
    pub fn goal(self, goal: &GoalRequest) -> (GoalRequest, Option<Task>) {
        let task = tasks::of(goal.kind);
        let Some((task, module)) = task.zip(self.module()) else {
            return (*goal, None);
        };
        let goal = GoalRequest {
            kind: GoalKind::CUSTOM,
            task: Text::new(self.name()),
            ..*goal
        };
        let task = Task {
            name: Name::new(self.name()),
            acting: governed(&task.acting, module),
            helping: task.helping.map(|track| governed(&track, module)),
        };
        (goal, Some(task))
    }
}

/// The same steps with another module for the grip, without those that feel stiffness.
fn governed(track: &Track, module: ModuleId) -> Track {
    let felt = track
        .iter()
        .filter(|s| s.transition != Transition::StiffnessKnown);
    let steps: Vec<Step> = felt
        .map(|step| Step {
            modules: replaced(step.modules, module),
            ..*step
        })
        .collect();
    // It has no more steps than before, and not all of them feel stiffness.
    Track::checked(&steps).unwrap_or(*track)
}

/// Only steps that may press hard are governed: the approach is the same for all.
fn replaced(modules: Selection, module: ModuleId) -> Selection {
    if !modules.contains(ModuleId::FORCE_LIMIT) {
        return modules;
    }
    let others: Vec<ModuleId> = modules.ids().filter(|id| !OURS.contains(id)).collect();
    Selection::of(&others).and(Selection::of(&[module]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn baselines_move_alike_and_govern_otherwise() {
        let kinds = [
            GoalKind::GRASP,
            GoalKind::PICK_PLACE,
            GoalKind::SCREW,
            GoalKind::ASSEMBLE,
        ];
        let laws = [GripPolicy::FixedForce(3.0), GripPolicy::SlipReactive(0.5)];
        for (kind, law) in kinds.into_iter().flat_map(|k| laws.map(|l| (k, l))) {
            let ours = tasks::of(kind).expect("built in");
            let asked = GoalRequest {
                kind,
                ..GoalRequest::default()
            };
            let (goal, task) = law.goal(&asked);
            let task = task.expect("a baseline has its own task");
            assert_eq!(
                (goal.kind, task.name.as_str()),
                (GoalKind::CUSTOM, law.name())
            );
            assert_eq!(task.demands(), ours.demands());
            let motions = |track: &Track| -> Vec<_> {
                let felt = track
                    .iter()
                    .filter(|s| s.transition != Transition::StiffnessKnown);
                felt.map(|step| (step.name, step.motion, step.transition))
                    .collect()
            };
            assert_eq!(motions(&task.acting), motions(&ours.acting));
            let tracks = [Some(task.acting), task.helping];
            for step in tracks.iter().flatten().flat_map(|track| track.iter()) {
                let ours = [ModuleId::PROBE, ModuleId::SLIP, ModuleId::FORCE_LIMIT];
                assert!(
                    !ours.iter().any(|id| step.modules.contains(*id)),
                    "{step:?}"
                );
            }
        }
        assert_eq!(GripPolicy::Ours.goal(&GoalRequest::default()).1, None);
    }

    #[test]
    fn a_fixed_force_is_f1() {
        let settings = GripPolicy::FixedForce(3.0).settings(&Settings::default());
        let thresholds = atas_core::thresholds::Thresholds::unknown(&settings.grasp);
        assert!((thresholds.f1_n - 3.0).abs() < 1e-12, "{thresholds:?}");
        assert_eq!(settings.check(), Ok(()));
    }
}
