//! Grip policies: the ATAS modules, and the baselines they are compared with.
//!
//! A baseline is a copy of a built-in task with the same motions, collision guard and Module 4, in
//! the same controller. One module, which ignores stiffness, replaces stiffness probe, Modules 1
//! and 2, and grip relaxation.
//!
//! A baseline can refuse an object. Module 3 sets down an object that slides at the baseline's
//! maximum force. Lift verification raises the force to that maximum if the object is not
//! suspended, then sets it down. Start force and maximum are the best of [`GripPolicy::candidates`]
//! on [`crate::seeds::TUNING`]: `atas eval tune`.

use atas_core::Settings;
use atas_core::modules::Selection;
use atas_core::tasks::{self, BehaviourTable, Motion, Name, Step, StepSequence, Task, Transition};
use shm_schemas::{GoalKind, GoalRequest, ModuleId, Text};

use crate::Task as EvaluatedTask;

/// Grip modules of the built-in tasks that a baseline omits.
const GRIP_MODULES: [ModuleId; 4] = [
    ModuleId::FIRST_TOUCH,
    ModuleId::PROBE,
    ModuleId::SLIP,
    ModuleId::RELAX,
];
/// Upper limit of F_1/F_2 ([`atas_core::thresholds::Thresholds`]).
const F1_OVER_F2_MAX: f64 = 0.8;
/// Longest step under a behaviour table, s. Design choice: several times a lift.
const TABLE_STEP_MAX_S: f64 = 20.0;
/// Candidates of the fixed force, N: up to the hand's limit.
const FIXED_CANDIDATES_N: [f64; 8] = [1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0];
/// Candidates of the slip-reactive start force, N.
const START_CANDIDATES_N: [f64; 3] = [0.35, 0.6, 1.0];
/// Candidates of the slip-reactive maximum, N.
const MAXIMUM_CANDIDATES_N: [f64; 3] = [2.0, 4.0, 8.0];

/// Grip policy.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum GripPolicy {
    /// ATAS modules of the built-in tasks: Modules 1, 2, 3, stiffness probe, grip relaxation.
    BuiltIn,
    /// Gripper that closes to this force per grasp side, N, and keeps it (F_1). Lift verification
    /// raises it by up to a quarter before it sets the object down.
    FixedForce(f64),
    /// Force rises by 8 % per 41 ms of slip (Romano et al. 2011): [`ModuleId::SLIP_REACTION`].
    SlipReactive {
        /// Start force per grasp side, N.
        start_n: f64,
        /// Maximum force per grasp side, N.
        ceiling_n: f64,
    },
    /// ATAS modules without this one (ablation).
    Without(ModuleId),
    /// Behaviour table (paper section III) that controls fingers and lift after the stiffness
    /// probe.
    Table {
        /// The table.
        table: BehaviourTable,
        /// True: Module 3 runs beside the table, as custom tasks require.
        force_limit: bool,
    },
}

/// Returns the baselines' best forces for a task, N: fixed force, slip-reactive start and maximum.
/// Best success by physics over the tuning seeds, then lowest force (`atas eval tune TASK`).
fn tuned_forces_n(task: EvaluatedTask) -> (f64, f64, f64) {
    match task {
        EvaluatedTask::Grasp | EvaluatedTask::PickPlace => (7.0, 1.0, 8.0),
        EvaluatedTask::Screw => (3.0, 0.35, 8.0),
        EvaluatedTask::Assembly => (3.0, 1.0, 4.0),
    }
}

impl GripPolicy {
    /// Returns the baselines of a task. The fixed force is `force_n`, or the best for the task.
    #[must_use]
    pub fn baselines(task: EvaluatedTask, force_n: Option<f64>) -> [Self; 2] {
        let (fixed_n, start_n, ceiling_n) = tuned_forces_n(task);
        let fixed_n = force_n.unwrap_or(fixed_n);
        [
            Self::FixedForce(fixed_n),
            Self::SlipReactive { start_n, ceiling_n },
        ]
    }

    /// Returns all baselines that tuning compares.
    #[must_use]
    pub fn candidates() -> Vec<Self> {
        let slip_reactive = START_CANDIDATES_N.into_iter().flat_map(|start_n| {
            MAXIMUM_CANDIDATES_N.map(|ceiling_n| Self::SlipReactive { start_n, ceiling_n })
        });
        FIXED_CANDIDATES_N
            .map(Self::FixedForce)
            .into_iter()
            .chain(slip_reactive)
            .collect()
    }

    /// Returns the name in reports.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::BuiltIn => "ours",
            Self::FixedForce(_) => "fixed_force",
            Self::SlipReactive { .. } => "slip_reactive",
            Self::Without(_) => "without",
            Self::Table { .. } => "table",
        }
    }

    /// Returns the forces as text; empty for the ATAS modules.
    #[must_use]
    pub fn setting(self) -> String {
        match self {
            Self::BuiltIn => String::new(),
            Self::FixedForce(force_n) => format!("{force_n} N"),
            Self::SlipReactive { start_n, ceiling_n } => format!("{start_n} to {ceiling_n} N"),
            Self::Without(module) => module.to_string(),
            Self::Table { table, .. } => format!("{:016x}", table.hash()),
        }
    }

    /// Returns the module that replaces the grip modules, if any.
    fn module(self) -> Option<ModuleId> {
        match self {
            Self::BuiltIn | Self::Without(_) | Self::Table { .. } => None,
            Self::FixedForce(_) => Some(ModuleId::FIRST_TOUCH),
            Self::SlipReactive { .. } => Some(ModuleId::SLIP_REACTION),
        }
    }

    /// Returns the controller settings for this policy.
    #[must_use]
    pub fn settings(self, ours: &Settings) -> Settings {
        let mut settings = *ours;
        let (f1_n, f2_n) = match self {
            Self::BuiltIn | Self::Without(_) | Self::Table { .. } => return settings,
            Self::FixedForce(force_n) => (force_n, force_n / F1_OVER_F2_MAX),
            Self::SlipReactive { start_n, ceiling_n } => (start_n, ceiling_n),
        };
        let grasp = &mut settings.grasp;
        (grasp.f1_min_n, grasp.f1_max_n) = (f1_n, f1_n);
        (grasp.f2_min_n, grasp.f2_max_n) = (f2_n, f2_n);
        settings
    }

    /// Returns the goal for this policy; a baseline adds its own task.
    #[must_use]
    pub fn goal(self, goal: &GoalRequest) -> (GoalRequest, Option<Task>) {
        let own = tasks::for_kind(goal.kind).and_then(|task| self.task(task));
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

    /// Returns a built-in task with this grip policy; `None` for the ATAS modules.
    fn task(self, built_in: &Task) -> Option<Task> {
        let govern = |track: &StepSequence| match self {
            Self::BuiltIn => None,
            Self::Without(module) => Some(without_module(track, module)),
            Self::Table { force_limit, .. } => Some(with_table(track, force_limit)),
            Self::FixedForce(_) | Self::SlipReactive { .. } => {
                self.module().map(|module| with_grip_module(track, module))
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

fn without_module(track: &StepSequence, module: ModuleId) -> StepSequence {
    let kept = |step: &Step| {
        let kept: Vec<ModuleId> = step.modules.ids().filter(|id| *id != module).collect();
        Step {
            modules: Selection::from_modules(&kept),
            ..*step
        }
    };
    let steps: Vec<Step> = track.iter().map(kept).collect();
    StepSequence::validated(&steps).unwrap_or(*track)
}

/// Lets the table control all steps after the stiffness probe, which continues to estimate.
fn with_table(track: &StepSequence, force_limit: bool) -> StepSequence {
    let beside: &[ModuleId] = if force_limit {
        &[ModuleId::FORCE_LIMIT]
    } else {
        &[]
    };
    let table = Selection::from_modules(&[ModuleId::BEHAVIOUR_TABLE, ModuleId::PROBE]);
    let table = table.union(Selection::from_modules(beside));
    let grips = |step: &&Step| step.transition != Transition::Gripped;
    let steps: Vec<Step> = track
        .iter()
        .filter(grips)
        .map(|step| Step {
            modules: match step.motion {
                _ if !step.modules.contains(ModuleId::FORCE_LIMIT) => step.modules,
                Motion::Carry(_) => table.union(Selection::from_modules(&[ModuleId::CARRY])),
                _ => table,
            },
            timeout_s: step.timeout_s.min(TABLE_STEP_MAX_S),
            ..*step
        })
        .collect();
    // Fewer steps than the valid input: never rejected.
    StepSequence::validated(&steps).unwrap_or(*track)
}

/// Replaces the grip modules by one module and drops the steps that measure stiffness.
fn with_grip_module(track: &StepSequence, module: ModuleId) -> StepSequence {
    let measured = track
        .iter()
        .filter(|s| s.transition != Transition::StiffnessKnown);
    let steps: Vec<Step> = measured
        .map(|step| Step {
            modules: replace_grip_modules(step.modules, module),
            ..*step
        })
        .collect();
    // No more steps than the valid input, and at least one remains: never rejected.
    StepSequence::validated(&steps).unwrap_or(*track)
}

/// Changes only steps with a force limit; the approach is equal for all policies.
fn replace_grip_modules(modules: Selection, module: ModuleId) -> Selection {
    if !modules.contains(ModuleId::FORCE_LIMIT) {
        return modules;
    }
    let others: Vec<ModuleId> = modules
        .ids()
        .filter(|id| !GRIP_MODULES.contains(id))
        .collect();
    Selection::from_modules(&others).union(Selection::from_modules(&[module]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn baselines_keep_motions_and_replace_grip_modules() {
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
            let ours = tasks::for_kind(kind).expect("built in");
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
            assert_eq!(task.requirements(), ours.requirements());
            let motions = |track: &StepSequence| -> Vec<_> {
                let measured = track
                    .iter()
                    .filter(|s| s.transition != Transition::StiffnessKnown);
                measured
                    .map(|step| (step.name, step.motion, step.transition))
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
        for refuses in [ModuleId::FORCE_LIMIT, ModuleId::LIFT_VERIFICATION] {
            assert!(lift.contains(refuses), "a baseline can refuse");
        }
        assert_eq!(GripPolicy::BuiltIn.goal(&GoalRequest::default()).1, None);
    }

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
    fn candidates_give_valid_settings() {
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
    fn fixed_force_sets_f1() {
        let settings = GripPolicy::FixedForce(3.0).settings(&Settings::default());
        let thresholds = atas_core::thresholds::Thresholds::for_unknown_object(&settings.grasp);
        assert!((thresholds.f1_n - 3.0).abs() < 1e-12, "{thresholds:?}");
        assert_eq!(settings.check(), Ok(()));
    }
}
