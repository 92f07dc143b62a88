//! Task executor: runs the steps of one hand's task and stores its measurements.
//!
//! ```text
//!            search step ends, object off-centre, rotated, or lift fails
//!   ┌──────────────────────────────────────────────┐
//!   │                                              ▼
//!  Task ◄───────────── object found again ───── Regrasp
//!   │ │                                            │
//!   │ └── object refused, obstacle, no support ────┴──► Recovery ──► refused or failed
//!   └──── last step done ──► Ended (the last step stays active)
//! ```
//!
//! A descent that touches the object is an `Evasion`: the hand withdraws and comes down beside it.
//!
//! `Course` is the state; each variant carries its own data. Within a course, the steps follow
//! each other by their [`Transition`]s. The object in the hand is a [`HeldObjectEstimator`].

mod evasion;
mod monitoring;
mod regrasp;
mod teleop;
mod transitions;

use self::regrasp::Corrections;
use self::teleop::Teleoperation;
use crate::held_object::{HeldObjectEstimator, LiftFinding, StepFacts};
use crate::modules::{Context, Modules, RELEASE_SHARE, Verdict};
use crate::path::Path;
use crate::perception::{ObjectPose, Percept, StiffnessFit};
use crate::planning::{Waypoints, path_of};
use crate::settings::Settings;
use crate::tasks::{
    BehaviourTable, HOLD_AFTER_GOAL, HOLD_AFTER_TELEOP, HOLD_FOUND, Motion, PUT_BACK, RAISE,
    REGRASP, Step, StepSequence, Transition, WITHDRAW,
};
use crate::thresholds::Thresholds;
use nalgebra::{Vector2, Vector3};
use robot_model::{Compression, GraspPose, PerSide, Transform};
use shm_schemas::{ModuleId, Reason};

/// Motion of the hand at the start of a tick.
#[derive(Clone, Copy, Debug)]
pub struct HandMotion<'a> {
    /// Path speed factor arbitrated in the previous tick, −1 (back) to 1.
    pub carry_scale: f64,
    /// Closing speed per grasp side arbitrated in the previous tick, m/s.
    pub closing_m_s: PerSide<f64>,
    /// Commanded grasp pose.
    pub pose: &'a GraspPose,
    /// Present closing axis, base frame, unit length, including the rotation of the wrist.
    pub closing_axis: Vector3<f64>,
    /// The wrist rotates the whole hand, where fingertips would pass each other.
    pub turns_by_wrist: bool,
    /// Measured frame of each fingertip.
    pub base_from_tip: &'a [Transform],
    /// Measured mean of the fingertips of each grasp side, base frame, m.
    pub side_m: PerSide<Vector3<f64>>,
    /// Compression of the fingertips under load.
    pub compression: Compression,
    /// Ratio of tactile to joint-estimated force, ≥ 1. Limits opening when the skin reports too
    /// much.
    pub tactile_over_torque: f64,
    /// Ratio of joint-estimated to tactile force, ≥ 1. Limits closing when the skin reports too
    /// little.
    pub torque_over_tactile: f64,
}

/// Result of the task in this tick.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Outcome {
    /// The task continues.
    Running,
    /// The next step began.
    NextStep,
    /// The task succeeded; the last step stays active.
    Succeeded,
    /// The task ended with a recovery from an object that cannot be handled.
    Refused(Reason),
    /// The task failed; the hand stays as it is.
    Failed(Reason),
}

/// Parameters of a grasp from the goal.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct GraspParameters {
    /// Expected width along the closing axis, m.
    pub width_m: f64,
    /// Hold time, s.
    pub hold_s: f64,
    /// Maximum grip force, N; zero if not given.
    pub max_force_n: f64,
}

impl GraspParameters {
    /// Parameters for an object found in the hand.
    const FOUND: Self = Self {
        width_m: 0.0,
        hold_s: f64::INFINITY,
        max_force_n: 0.0,
    };

    /// Returns F_1 and F_2 before the first touch.
    fn initial_thresholds(&self, settings: &Settings) -> Thresholds {
        Thresholds::for_unknown_object(&settings.grasp)
            .with_force_limit(self.max_force_n, &settings.grasp)
    }
}

/// Task state of one hand.
#[derive(Clone, Copy, Debug)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct TaskExecutor {
    sequence: StepSequence,
    table: Option<BehaviourTable>,
    course: Course,
    /// Present step of the course, and time since its start, s.
    index: usize,
    step_s: f64,
    path: Path,
    waypoints: Waypoints,
    parameters: GraspParameters,
    object: HeldObjectEstimator,
    object_pose: Option<ObjectPose>,
    corrections: Corrections,
    /// Displacement of the object from its commanded place, base frame, m.
    displacement_m: Vector2<f64>,
    meeting_point: u8,
    peer_meeting_point: u8,
    slip_warning: Option<Reason>,
    teleoperation: Teleoperation,
}

/// Course of a task.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
enum Course {
    /// Steps of the task.
    Task,
    /// Puts the object back or opens, grasps again, and resumes the task at this step.
    Regrasp { resume_step: usize },
    /// Withdraws from a touch during the descent, and resumes the task at this step, beside it.
    Evasion { resume_step: usize },
    /// Ends a task that cannot continue, for this reason.
    Recovery(Recovery, Reason),
    /// The task has ended; its last step stays active.
    Ended,
}

/// Recovery from a task that cannot continue.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
enum Recovery {
    /// Puts the object back at its source.
    PutBack,
    /// Lifts the object again and holds it.
    Raise,
    /// Withdraws from an obstacle.
    Withdraw,
}

impl TaskExecutor {
    /// Starts a task at the present pose.
    #[must_use]
    pub fn start(
        sequence: StepSequence,
        waypoints: Waypoints,
        now: &GraspPose,
        parameters: GraspParameters,
        settings: &Settings,
    ) -> Self {
        let mut executor = Self {
            sequence,
            table: None,
            course: Course::Task,
            index: 0,
            step_s: 0.0,
            path: Path::stationary(*now),
            waypoints,
            parameters,
            object: HeldObjectEstimator::new(parameters.initial_thresholds(settings)),
            object_pose: None,
            corrections: Corrections::default(),
            displacement_m: Vector2::zeros(),
            meeting_point: 0,
            peer_meeting_point: 0,
            slip_warning: None,
            teleoperation: Teleoperation::default(),
        };
        executor.path = executor.plan(now, settings);
        executor.init_step();
        executor
    }

    /// Returns the executor with a table for the behaviour table module.
    #[must_use]
    pub fn with_table(self, table: Option<BehaviourTable>) -> Self {
        Self { table, ..self }
    }

    /// Holds an object found in the hand, with its reported F_2, N, or zero if unknown.
    #[must_use]
    pub fn hold_found(
        waypoints: Waypoints,
        now: &GraspPose,
        percept: &Percept,
        reported_f2_n: f64,
        settings: &Settings,
    ) -> Self {
        let (weakest_n, strongest_n) = percept.normal_range_n();
        let thresholds =
            Thresholds::for_existing_grip([weakest_n, strongest_n], reported_f2_n, &settings.grasp);
        Self {
            object: HeldObjectEstimator::for_found_object(thresholds, now.centre_m),
            ..Self::start(HOLD_FOUND, waypoints, now, GraspParameters::FOUND, settings)
        }
    }

    /// The present step.
    #[must_use]
    pub fn step(&self) -> &Step {
        &self.steps()[self.index]
    }

    /// Steps of the present course.
    fn steps(&self) -> &[Step] {
        match self.course {
            Course::Regrasp { .. } => &REGRASP,
            Course::Evasion { .. } => &WITHDRAW,
            Course::Task | Course::Recovery(..) | Course::Ended => &self.sequence,
        }
    }

    /// Index of the present step.
    #[must_use]
    pub fn index(&self) -> usize {
        self.index
    }

    /// Share of the steps that are done.
    #[must_use]
    pub fn progress(&self) -> f64 {
        self.index as f64 / self.steps().len() as f64
    }

    /// Estimate of the object in the hand.
    #[must_use]
    pub fn object(&self) -> &HeldObjectEstimator {
        &self.object
    }

    /// Time for which the fingers have been closing towards contact, s.
    #[must_use]
    pub fn closing_s(&self) -> f64 {
        match self.step().transition {
            Transition::AllTouched => self.step_s,
            _ => 0.0,
        }
    }

    /// Stiffness that the previous step has measured.
    #[must_use]
    pub fn stiffness_before(&self) -> Option<StiffnessFit> {
        let previous = self.steps().get(self.index.checked_sub(1)?)?;
        let measured = previous.transition == Transition::StiffnessKnown;
        self.object.stiffness().filter(|_| measured)
    }

    /// Warning reason if the object in the hand slips.
    #[must_use]
    pub fn slip_warning(&self) -> Option<Reason> {
        self.slip_warning
    }

    /// Reason of the recovery in progress.
    #[must_use]
    pub fn recovery_reason(&self) -> Option<Reason> {
        match self.course {
            Course::Recovery(_, reason) => Some(reason),
            Course::Task | Course::Regrasp { .. } | Course::Evasion { .. } | Course::Ended => None,
        }
    }

    /// Last meeting point reached.
    #[must_use]
    pub fn meeting_point(&self) -> u8 {
        self.meeting_point
    }

    /// Sets the meeting point and the object displacement of the other hand.
    pub fn receive_peer(&mut self, reached: u8, displaced_m: Vector2<f64>) {
        self.peer_meeting_point = reached;
        self.waypoints.shift_target(displaced_m);
    }

    /// Returns true if the hand grips an object.
    #[must_use]
    pub fn grips(&self) -> bool {
        self.object.is_held()
    }

    /// Context for the modules.
    #[must_use]
    pub fn context<'a>(
        &'a self,
        settings: &'a Settings,
        step_s: f64,
        hand: &'a HandMotion<'a>,
    ) -> Context<'a> {
        Context {
            settings,
            step_s,
            object: self.object.object(),
            hand,
            path: &self.path,
            table: self.table.as_ref(),
            turning: self.waypoints.turning(),
            lowering_m: self.lowering_m(hand.pose),
            teleop_target: self
                .teleoperation
                .target
                .as_ref()
                .filter(|_| self.step().motion == Motion::Teleop),
        }
    }

    /// Returns the depth of a lowering step below the end of its path, m; `None` in other steps.
    fn lowering_m(&self, now: &GraspPose) -> Option<f64> {
        match self.step().motion {
            Motion::Lower => Some(self.waypoints.lowering_m()),
            Motion::Teleop => self.target_below_m(now),
            _ => None,
        }
    }

    /// Updates the object before the modules run. Inputs: percept, motion of the hand, fingertip
    /// distance, m, and object pose.
    pub fn update_measured(
        &mut self,
        percept: &Percept,
        hand: &HandMotion<'_>,
        (gap_m, object_pose): (f64, Option<ObjectPose>),
        settings: &Settings,
        step_s: f64,
    ) {
        self.step_s += step_s;
        self.object_pose = object_pose;
        let (had_touched, facts) = (self.object.object().all_touched, self.step_facts(hand.pose));
        self.object
            .update(percept, hand, (gap_m, step_s), facts, settings);
        if facts.searches && self.object.object().all_touched && !had_touched {
            self.teleoperation.touched_opening_m = hand.pose.half_opening_m.iter().sum();
        }
        self.slip_warning = self.check_slip(percept);
    }

    /// Returns true in free motion: a touch is an obstacle.
    pub(crate) fn moves_freely(&self) -> bool {
        self.step().modules.contains(ModuleId::CONTACT_GUARD)
    }

    /// Returns true while the fingers close towards the first touch.
    pub(crate) fn searches(&self) -> bool {
        self.step().transition == Transition::AllTouched
    }

    /// Receives the result of lift verification.
    pub fn receive_finding(&mut self, finding: LiftFinding) {
        self.object.receive(finding, self.is_monitored());
    }

    fn step_facts(&self, now: &GraspPose) -> StepFacts {
        let step = self.step();
        StepFacts {
            searches: self.searches(),
            verifies_lift: step.modules.contains(ModuleId::LIFT_VERIFICATION),
            lowers: self.lowering_m(now).is_some(),
            steadies: matches!(step.transition, Transition::Met(_))
                && step.modules.contains(ModuleId::FIRST_TOUCH),
            is_monitored: self.is_monitored(),
        }
    }

    /// Continues with a task for the object in the hand; its thresholds and stiffness stay. In-hand
    /// monitoring restarts, because carrying the robot between tasks resembles dropping.
    pub fn continue_with(
        &mut self,
        (sequence, waypoints, parameters): (StepSequence, Waypoints, GraspParameters),
        now: &GraspPose,
        settings: &Settings,
        modules: &mut Modules,
    ) {
        (self.sequence, self.waypoints) = (sequence, waypoints);
        (self.table, self.parameters) = (None, parameters);
        (self.course, self.corrections) = (Course::Task, Corrections::default());
        (self.meeting_point, self.peer_meeting_point) = (0, 0);
        self.object.restart_in_hand();
        self.enter(0, now, settings, modules);
    }

    /// Switches to holding when a goal ends with an object in hand.
    pub fn hold_object(&mut self, now: &GraspPose, settings: &Settings, modules: &mut Modules) {
        if self.step().transition != Transition::Held {
            self.sequence = if self.is_teleoperated() {
                HOLD_AFTER_TELEOP
            } else {
                HOLD_AFTER_GOAL
            };
            (self.course, self.corrections) = (Course::Ended, Corrections::default());
            self.enter(0, now, settings, modules);
        }
        self.course = Course::Ended;
    }
}
