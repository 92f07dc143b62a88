//! What governs the grip: our modules, or a baseline to beat.
//!
//! A baseline is a task made of the built-in one: the same motions, the same guard, the same Module 4; but where the
//! built-in task has its modules for the grip (stiffness probe, modules 1 and 2, what gives force back), the baseline has one
//! that knows no stiffness. It runs in the same controller, by the same arms.
//!
//! It may refuse as ours do: Module 3 stops at the most that the baseline presses with and sets down what slides there all the
//! same, the load test presses up to that force what does not hang, and then sets it down. That force, and the one it
//! starts from, are the best of [`GripPolicy::candidates`] on [`crate::seeds::TUNING`]: `atas eval tune`.

use atas_core::Settings;
use atas_core::modules::Selection;
use atas_core::tasks::{self, BehaviourTable, Motion, Name, Step, Task, Track, Transition};
use shm_schemas::{GoalKind, GoalRequest, ModuleId, Text};

use crate::task::Task as EvaluatedTask;

/// What the built-in tasks govern the grip with, and a baseline does without.
const OURS: [ModuleId; 4] = [
    ModuleId::FIRST_TOUCH,
    ModuleId::PROBE,
    ModuleId::SLIP,
    ModuleId::RELAX,
];
/// Share of F_2 that F_1 never exceeds ([`atas_core::thresholds::Thresholds`]).
const F1_BELOW_F2: f64 = 0.8;
/// Longest time of a step that a table governs, s (ours: several times a lift): one that leaves the hand standing is no better
/// for being waited for.
const READ_OFF_S: f64 = 20.0;
/// Fixed forces that are tried, N: up to what the hand may press.
const FIXED_N: [f64; 8] = [1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0];
/// Forces from which the slip-reactive baseline is tried, N.
const START_N: [f64; 3] = [0.35, 0.6, 1.0];
/// Most that it presses with, as tried, N.
const CEILING_N: [f64; 3] = [2.0, 4.0, 8.0];

/// A policy of the grip.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum GripPolicy {
    /// Modules 1, 2, 3, the stiffness probe and relaxing, as the built-in tasks have them.
    Ours,
    /// A gripper that closes until it presses with this force per finger, N, and keeps it: F_1 is the force. What the load
    /// test finds standing it presses with up to a quarter more before it sets it down.
    FixedForce(f64),
    /// The force rises by 8 % per 41 ms of slip, after Romano et al. 2011: [`ModuleId::SLIP_REACTION`].
    SlipReactive {
        /// From this force per finger, N.
        start_n: f64,
        /// Up to this one, N.
        ceiling_n: f64,
    },
    /// Ours without one of its modules: what is it worth?
    Without(ModuleId),
    /// A behaviour table (paper section III) governs fingers and lift once the stiffness is known.
    Table {
        /// The table.
        table: BehaviourTable,
        /// Whether Module 3 stands beside it, as a user's own task must have it.
        force_limit: bool,
    },
}

/// Forces, N, with which the baselines serve a task best: the fixed one, the one that the slip-reactive starts from and its most.
/// They have the most successes by physics over tuning seeds, and of equal ones are the gentlest (`atas eval tune TASK`).
fn best(task: EvaluatedTask) -> (f64, f64, f64) {
    match task {
        EvaluatedTask::Grasp | EvaluatedTask::PickPlace => (7.0, 1.0, 8.0),
        EvaluatedTask::Screw => (3.0, 0.35, 8.0),
        EvaluatedTask::Assembly => (3.0, 1.0, 4.0),
    }
}

impl GripPolicy {
    /// The baselines of a task, the first with this force or the best for the task.
    #[must_use]
    pub fn baselines(task: EvaluatedTask, force_n: Option<f64>) -> [Self; 2] {
        let (fixed_n, start_n, ceiling_n) = best(task);
        let fixed_n = force_n.unwrap_or(fixed_n);
        [
            Self::FixedForce(fixed_n),
            Self::SlipReactive { start_n, ceiling_n },
        ]
    }

    /// Everything that is tried for the baselines.
    #[must_use]
    pub fn candidates() -> Vec<Self> {
        let slip_reactive = START_N.into_iter().flat_map(|start_n| {
            CEILING_N.map(|ceiling_n| Self::SlipReactive { start_n, ceiling_n })
        });
        FIXED_N
            .map(Self::FixedForce)
            .into_iter()
            .chain(slip_reactive)
            .collect()
    }

    /// Its name in reports.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Ours => "ours",
            Self::FixedForce(_) => "fixed_force",
            Self::SlipReactive { .. } => "slip_reactive",
            Self::Without(_) => "without",
            Self::Table { .. } => "table",
        }
    }

    /// Its forces, in words; empty for ours.
    #[must_use]
    pub fn setting(self) -> String {
        match self {
            Self::Ours => String::new(),
            Self::FixedForce(force_n) => format!("{force_n} N"),
            Self::SlipReactive { start_n, ceiling_n } => format!("{start_n} to {ceiling_n} N"),
            Self::Without(module) => module.to_string(),
            Self::Table { table, .. } => format!("{:016x}", table.hash()),
        }
    }

    /// The module that governs the grip instead of ours; `None` for what is made of ours.
    fn module(self) -> Option<ModuleId> {
        match self {
            Self::Ours | Self::Without(_) | Self::Table { .. } => None,
            Self::FixedForce(_) => Some(ModuleId::FIRST_TOUCH),
            Self::SlipReactive { .. } => Some(ModuleId::SLIP_REACTION),
        }
    }

    /// The controller's settings under this policy.
    #[must_use]
    pub fn settings(self, ours: &Settings) -> Settings {
        let mut settings = *ours;
        let (f1_n, f2_n) = match self {
            Self::Ours | Self::Without(_) | Self::Table { .. } => return settings,
            Self::FixedForce(force_n) => (force_n, force_n / F1_BELOW_F2),
            Self::SlipReactive { start_n, ceiling_n } => (start_n, ceiling_n),
        };
        let grasp = &mut settings.grasp;
        (grasp.f1_min_n, grasp.f1_max_n) = (f1_n, f1_n);
        (grasp.f2_min_n, grasp.f2_max_n) = (f2_n, f2_n);
        settings
    }

    /// The goal under this policy: for a baseline, the same with a task of its own.
    #[must_use]
    pub fn goal(self, goal: &GoalRequest) -> (GoalRequest, Option<Task>) {
        let own = tasks::of(goal.kind).and_then(|task| self.task(task));
        let Some(task) = own else {
            return (*goal, None);
        };
        let goal = GoalRequest {
            kind: GoalKind::CUSTOM,
            task: Text::new(self.name()),
            ..*goal
        };
        (goal, Some(task))
    }

    /// A task that moves as a built-in one does and grips by this policy; `None` for ours.
    fn task(self, built_in: &Task) -> Option<Task> {
        let govern = |track: &Track| match self {
            Self::Ours => None,
            Self::Without(module) => Some(without(track, module)),
            Self::Table { force_limit, .. } => Some(read_off(track, force_limit)),
            Self::FixedForce(_) | Self::SlipReactive { .. } => {
                self.module().map(|module| governed(track, module))
            }
        };
        Some(Task {
            name: Name::new(self.name()),
            acting: govern(&built_in.acting)?,
            helping: built_in.helping.as_ref().and_then(govern),
            table: match self {
                Self::Table { table, .. } => Some(table),
                _ => None,
            },
        })
    }
}

/// The same steps without a module.
fn without(track: &Track, module: ModuleId) -> Track {
    let kept = |step: &Step| {
        let kept: Vec<ModuleId> = step.modules.ids().filter(|id| *id != module).collect();
        Step {
            modules: Selection::of(&kept),
            ..*step
        }
    };
    let steps: Vec<Step> = track.iter().map(kept).collect();
    Track::checked(&steps).unwrap_or(*track)
}

/// The same steps up to the probe; then a table grips, lifts and holds, and the probe goes on listening.
fn read_off(track: &Track, force_limit: bool) -> Track {
    let beside: &[ModuleId] = if force_limit {
        &[ModuleId::FORCE_LIMIT]
    } else {
        &[]
    };
    let table = Selection::of(&[ModuleId::BEHAVIOUR_TABLE, ModuleId::PROBE]);
    let table = table.and(Selection::of(beside));
    let grips = |step: &&Step| step.transition != Transition::Gripped;
    let steps: Vec<Step> = track
        .iter()
        .filter(grips)
        .map(|step| Step {
            modules: match step.motion {
                _ if !step.modules.contains(ModuleId::FORCE_LIMIT) => step.modules,
                Motion::Carry(_) => table.and(Selection::of(&[ModuleId::CARRY])),
                _ => table,
            },
            timeout_s: step.timeout_s.min(READ_OFF_S),
            ..*step
        })
        .collect();
    // It has fewer steps than before.
    Track::checked(&steps).unwrap_or(*track)
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
        let slip_reactive = GripPolicy::SlipReactive {
            start_n: 0.5,
            ceiling_n: 8.0,
        };
        let policies = [GripPolicy::FixedForce(3.0), slip_reactive];
        for (kind, policy) in kinds.into_iter().flat_map(|k| policies.map(|l| (k, l))) {
            let ours = tasks::of(kind).expect("built in");
            let asked = GoalRequest {
                kind,
                ..GoalRequest::default()
            };
            let (goal, task) = policy.goal(&asked);
            let task = task.expect("a baseline has its own task");
            assert_eq!(
                (goal.kind, task.name.as_str()),
                (GoalKind::CUSTOM, policy.name())
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
                let ours = [ModuleId::PROBE, ModuleId::SLIP, ModuleId::RELAX];
                assert!(
                    !ours.iter().any(|id| step.modules.contains(*id)),
                    "{step:?}"
                );
            }
        }
        let lift = slip_reactive_lift();
        for refuses in [ModuleId::FORCE_LIMIT, ModuleId::LOAD_TEST] {
            assert!(lift.contains(refuses), "a baseline may refuse");
        }
        assert_eq!(GripPolicy::Ours.goal(&GoalRequest::default()).1, None);
    }

    /// The modules of a baseline's step that lifts.
    fn slip_reactive_lift() -> Selection {
        let policy = GripPolicy::baselines(EvaluatedTask::Grasp, None)[1];
        let asked = GoalRequest {
            kind: GoalKind::GRASP,
            ..GoalRequest::default()
        };
        let task = policy.goal(&asked).1.expect("a baseline has its own task");
        let lift = task
            .acting
            .iter()
            .find(|step| step.name == Name::new("lift"));
        lift.expect("a step that lifts").modules
    }

    #[test]
    fn every_candidate_can_be_set() {
        for policy in GripPolicy::candidates() {
            let settings = policy.settings(&Settings::default());
            assert_eq!(settings.check(), Ok(()), "{policy:?}");
        }
        for task in [
            EvaluatedTask::Grasp,
            EvaluatedTask::PickPlace,
            EvaluatedTask::Screw,
            EvaluatedTask::Assembly,
        ] {
            for best in GripPolicy::baselines(task, None) {
                assert!(GripPolicy::candidates().contains(&best), "{best:?}");
            }
        }
    }

    #[test]
    fn a_fixed_force_is_f1() {
        let settings = GripPolicy::FixedForce(3.0).settings(&Settings::default());
        let thresholds = atas_core::thresholds::Thresholds::unknown(&settings.grasp);
        assert!((thresholds.f1_n - 3.0).abs() < 1e-12, "{thresholds:?}");
        assert_eq!(settings.check(), Ok(()));
    }
}
