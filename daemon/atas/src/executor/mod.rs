//! Task executor: runs the steps of one hand's task and stores its measurements.

mod in_hand;
mod regrasp;
mod teleop;
mod transitions;
mod verification;

use self::in_hand::InHandMonitor;
use self::regrasp::Regrasp;
use self::verification::GripVerification;
use crate::modules::{Context, Finding, Modules, RELEASE_SHARE, Verdict, force_range_n};
use crate::path::Path;
use crate::perception::{ObjectPose, Percept, StiffnessFit};
use crate::planning::{Waypoints, path_of};
use crate::settings::Settings;
use crate::tasks::{
    BehaviourTable, HOLD_AFTER_GOAL, HOLD_AFTER_TELEOP, HOLD_FOUND, Motion, PUT_BACK, RAISE, Step,
    StepSequence, Transition, WITHDRAW,
};
use crate::teleop::TeleopTarget;
use crate::thresholds::Thresholds;
use nalgebra::{Vector2, Vector3};
use robot_model::{Compression, GRASP_SIDES, GraspPose, Transform};
use shm_schemas::{Cause, ModuleId, Reason};

/// Contact loss of a gripped object until it counts as lost, s (design choice: longer than contact
/// bounce).
const LOST_AFTER_S: f64 = 0.05;
/// Slip duration on one side before a warning, s (design choice: several times the response time of
/// Module 2).
const SLIP_WARNING_S: f64 = 0.1;
/// Duration of slip, and slide under a sudden load, before a warning, s, m (design choice: an
/// object that the grip catches within this time slides by about three millimetres. A slowly
/// growing load that the grip follows gives a smaller slide).
const OVERLOAD_WARNING_S: f64 = 0.05;
const OVERLOAD_SLIDE_M: f64 = 0.001;
/// Duration of a drift before a warning, s (design choice: longer than a disturbance).
const DRIFT_WARNING_S: f64 = 0.5;
/// Slip duration on both sides, or drop duration, at F_2 before the object is put back, s (design
/// choice).
const OUT_OF_FORCE_S: f64 = 0.03;
/// Friction utilisation below which slip is ignored (design choice): a light load on a firm grip is
/// noise.
const SLIP_UTILISATION: f64 = 0.9;
/// Half opening at which any search ends, m (design choice): the fingertips meet below it.
const FINGERTIPS_MEET_M: f64 = 0.001;

/// Motion of the hand at the start of a tick.
#[derive(Clone, Copy, Debug)]
pub struct HandMotion<'a> {
    /// Path speed factor arbitrated in the previous tick.
    pub carry_scale: f64,
    /// Closing speed per grasp side arbitrated in the previous tick, m/s.
    pub closing_m_s: [f64; GRASP_SIDES],
    /// Commanded grasp pose.
    pub frame: &'a GraspPose,
    /// Current closing axis, base frame, unit length.
    pub closing_axis: Vector3<f64>,
    /// See [`Context::turns_by_wrist`].
    pub turns_by_wrist: bool,
    /// Measured frame of each fingertip.
    pub base_from_tip: &'a [Transform],
    /// Measured mean of the fingertips of each grasp side, base frame, m.
    pub side_m: [Vector3<f64>; GRASP_SIDES],
    /// Compression of the fingertips under load.
    pub compression: Compression,
    /// Ratio of tactile to torque-estimated force, ≥ 1.
    pub tactile_over_torque: f64,
    /// Ratio of torque-estimated to tactile force, ≥ 1.
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
    index: usize,
    step_s: f64,
    path: Path,
    waypoints: Waypoints,
    parameters: GraspParameters,
    thresholds: Thresholds,
    stiffness: Option<StiffnessFit>,
    all_touched: bool,
    touch_gap_m: f64,
    closing_m: f64,
    lifted_from_m: Option<Vector3<f64>>,
    carried_m: f64,
    suspended: bool,
    minimises_grip: bool,
    verification: GripVerification,
    in_hand: InHandMonitor,
    /// Duration of dropping, s.
    drop_s: f64,
    ended: bool,
    no_contact_s: f64,
    slip_warning: Option<Reason>,
    /// Duration of a drift of the grip force, s.
    drift_s: f64,
    holds: bool,
    /// The object was found in the hand. Its origin is unknown, so it is never put back.
    found_in_hand: bool,
    meeting_point: u8,
    peer_meeting_point: u8,
    object_pose: Option<ObjectPose>,
    regrasp: Regrasp,
    /// Displacement of the object from its commanded place, base frame, m.
    displacement_m: Vector2<f64>,
    teleop_target: Option<TeleopTarget>,
    /// Opening at the start of a teleoperated grip, later at the touch of all sides, m.
    touched_opening_m: f64,
    recovery: Option<(Recovery, Reason)>,
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
        track: StepSequence,
        waypoints: Waypoints,
        now: &GraspPose,
        wishes: GraspParameters,
        settings: &Settings,
    ) -> Self {
        let mut runner = Self {
            sequence: track,
            table: None,
            index: 0,
            step_s: 0.0,
            path: Path::stationary(*now),
            waypoints,
            parameters: wishes,
            thresholds: wishes.initial_thresholds(settings),
            stiffness: None,
            all_touched: false,
            touch_gap_m: 0.0,
            closing_m: 0.0,
            lifted_from_m: None,
            carried_m: 0.0,
            suspended: false,
            minimises_grip: false,
            verification: GripVerification::default(),
            in_hand: InHandMonitor::default(),
            drop_s: 0.0,
            ended: false,
            no_contact_s: 0.0,
            slip_warning: None,
            drift_s: 0.0,
            holds: false,
            found_in_hand: false,
            meeting_point: 0,
            peer_meeting_point: 0,
            object_pose: None,
            regrasp: Regrasp::default(),
            displacement_m: Vector2::zeros(),
            teleop_target: None,
            touched_opening_m: 0.0,
            recovery: None,
        };
        runner.path = runner.plan(now, settings);
        runner.init_step();
        runner
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
        let (weakest_n, strongest_n) = force_range_n(percept);
        Self {
            thresholds: Thresholds::for_existing_grip(
                [weakest_n, strongest_n],
                reported_f2_n,
                &settings.grasp,
            ),
            all_touched: true,
            verification: GripVerification::for_found_grip(percept),
            lifted_from_m: Some(now.centre_m),
            holds: true,
            found_in_hand: true,
            ..Self::start(HOLD_FOUND, waypoints, now, GraspParameters::FOUND, settings)
        }
    }

    /// The present step.
    #[must_use]
    pub fn step(&self) -> &Step {
        &self.steps()[self.index]
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

    /// Grip thresholds F_1 and F_2.
    #[must_use]
    pub fn thresholds(&self) -> Thresholds {
        self.thresholds
    }

    /// Estimated stiffness, once known.
    #[must_use]
    pub fn stiffness(&self) -> Option<StiffnessFit> {
        self.stiffness
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
        self.stiffness
            .filter(|_| previous.transition == Transition::StiffnessKnown)
    }

    /// Carried distance, m.
    #[must_use]
    pub fn carried_m(&self) -> f64 {
        self.carried_m
    }

    /// Warning reason if the object in the hand slips.
    #[must_use]
    pub fn slip_warning(&self) -> Option<Reason> {
        self.slip_warning
    }

    /// Warning reason if the grip force does not match the opening of the hand.
    #[must_use]
    pub fn drift_warning(&self) -> Option<Reason> {
        if self.drift_s <= DRIFT_WARNING_S {
            return None;
        }
        let grip = self.verification.verified_grip()?;
        let [now_n, verified_n] = [grip.normal_n, grip.verified_normal_n]
            .map(|normal_n| normal_n.iter().sum::<f64>() / GRASP_SIDES as f64);
        let cause = Cause::FORCE_AGAINST_OPENING;
        Some(Reason::with_limit(cause, now_n, verified_n))
    }

    /// Reason of the recovery in progress.
    #[must_use]
    pub fn recovery_reason(&self) -> Option<Reason> {
        self.recovery.map(|(_, reason)| reason)
    }

    /// Last meeting point reached.
    #[must_use]
    pub fn meeting_point(&self) -> u8 {
        self.meeting_point
    }

    /// Returns true if the hand grips an object.
    #[must_use]
    pub fn grips(&self) -> bool {
        self.holds && self.no_contact_s <= LOST_AFTER_S
    }

    /// Context for the modules.
    #[must_use]
    pub fn context<'a>(
        &'a self,
        settings: &'a Settings,
        step_s: f64,
        motion: HandMotion<'a>,
    ) -> Context<'a> {
        Context {
            settings,
            step_s,
            thresholds: self.thresholds,
            min_force_n: self.min_force_n(settings),
            all_touched: self.all_touched,
            closing_m: self.closing_m,
            compression: motion.compression,
            carried_m: self.carried_m,
            suspended: self.suspended || !self.step().modules.contains(ModuleId::LIFT_VERIFICATION),
            minimises_grip: self.minimises_grip,
            verified: self.verification.is_verified(),
            verified_grip: self.verification.verified_grip(),
            table: self.table.as_ref(),
            path: &self.path,
            carry_scale: motion.carry_scale,
            closing_m_s: motion.closing_m_s,
            pose: motion.frame,
            closing_axis: motion.closing_axis,
            turns_by_wrist: motion.turns_by_wrist,
            base_from_tip: motion.base_from_tip,
            side_m: motion.side_m,
            tactile_over_torque: motion.tactile_over_torque,
            torque_over_tactile: motion.torque_over_tactile,
            turning: self.waypoints.turning(),
            lowering_m: match self.step().motion {
                Motion::Lower => Some(self.waypoints.lowering_m()),
                Motion::Teleop => self.target_below_m(motion.frame),
                _ => None,
            },
            teleop_target: self
                .teleop_target
                .as_ref()
                .filter(|_| self.step().motion == Motion::Teleop),
        }
    }

    /// Returns the minimum grip force, N: F_1 at first touch, lower for a carried object.
    fn min_force_n(&self, settings: &Settings) -> f64 {
        let carries = self.holds && self.lifted_from_m.is_some();
        let carry_min_n = settings.grasp.carry_min_n;
        if carries && carry_min_n < self.thresholds.f1_n {
            carry_min_n
        } else {
            self.thresholds.f1_n
        }
    }

    /// Processes the module findings; `down_n` is the vertical load on the fingers, N, `load_n` the
    /// net load across the closing axis, and `opening_m` the commanded opening.
    pub fn update_findings(
        &mut self,
        percept: &Percept,
        [down_n, load_n]: [f64; 2],
        opening_m: f64,
        finding: Finding,
    ) {
        self.verification.update(percept, load_n, opening_m);
        if finding.suspended && !self.suspended {
            self.verification.set_verified();
        }
        self.suspended |= finding.suspended;
        self.minimises_grip = finding.minimises_grip;
        self.drift_s = if finding.drifts {
            self.drift_s + percept.step_s
        } else {
            0.0
        };
        let sinks = finding.slips && self.suspended;
        self.drop_s = if sinks {
            self.drop_s + percept.step_s
        } else {
            0.0
        };
        let carries = self.holds && self.lifted_from_m.is_some() && !self.found_in_hand;
        // A teleoperated hand may place its object at any time.
        if carries && self.step().motion != Motion::Lower && !self.is_teleoperated() {
            let is_tested = self.step().modules.contains(ModuleId::LIFT_VERIFICATION);
            let facts = (finding, self.suspended, is_tested);
            self.in_hand.update(percept, down_n, self.carried_m, facts);
        }
    }

    /// Sets the meeting point and the object displacement of the other hand.
    pub fn receive_peer(&mut self, reached: u8, displaced_m: Vector2<f64>) {
        self.peer_meeting_point = reached;
        self.waypoints.shift_target(displaced_m);
    }

    /// Updates contact, closing and carried distance before the modules run. Inputs: fingertip
    /// distance, m, object pose, and commanded pose `now`.
    pub fn update_measured(
        &mut self,
        percept: &Percept,
        (gap_m, measured): (f64, Option<ObjectPose>),
        now: &GraspPose,
        step_s: f64,
    ) {
        self.step_s += step_s;
        self.object_pose = measured;
        let touching = percept.sides.iter().all(|f| f.in_contact);
        if touching && !self.all_touched && self.step().transition == Transition::AllTouched {
            self.all_touched = true;
            self.touch_gap_m = gap_m;
            self.touched_opening_m = now.half_opening_m.iter().sum();
        }
        self.closing_m = self.touch_gap_m - gap_m;
        if let Some(from_m) = self.lifted_from_m {
            self.carried_m = (now.centre_m - from_m).norm();
        }
        self.slip_warning = self.check_slip(percept);
        self.no_contact_s = if touching {
            0.0
        } else {
            self.no_contact_s + step_s
        };
    }

    /// Returns the warning reason if a held object slips.
    fn check_slip(&self, percept: &Percept) -> Option<Reason> {
        let (slip_s, limit_s) = if self.verification.overload_m() > OVERLOAD_SLIDE_M {
            (slip_s(percept), OVERLOAD_WARNING_S)
        } else {
            (self.unverified_slip_s(percept), SLIP_WARNING_S)
        };
        (self.holds_object() && slip_s > limit_s)
            .then(|| Reason::with_limit(Cause::SLIDING, slip_s, limit_s))
    }

    /// Returns the duration of a slip beyond the verified grip, s.
    fn unverified_slip_s(&self, percept: &Percept) -> f64 {
        slip_s(percept).min(self.verification.unverified_s())
    }

    fn holds_object(&self) -> bool {
        self.step().transition == Transition::Held && self.grips()
    }

    /// Returns the reason to put back an object that slips despite F_2.
    fn out_of_force(&self, percept: &Percept) -> Option<Reason> {
        let (_, strongest_n) = force_range_n(percept);
        let f2_n = self.thresholds.f2_n;
        let everywhere = percept
            .sides
            .iter()
            .all(|finger| finger.gross_slip_s > OUT_OF_FORCE_S);
        let slips = self.holds_object() && self.unverified_slip_s(percept) > SLIP_WARNING_S;
        let slides = (slips && everywhere) || self.drop_s > OUT_OF_FORCE_S;
        let spent = slides && strongest_n > RELEASE_SHARE * f2_n;
        let reason = Reason::with_limit(Cause::OUT_OF_FORCE, strongest_n, f2_n);
        (spent && self.recovery.is_none() && !self.found_in_hand)
            .then(|| reason.with_module(ModuleId::FORCE_LIMIT))
    }
}

impl TaskExecutor {
    /// Continues with a task for the object in the hand; its thresholds and stiffness stay. In-hand
    /// monitoring restarts, because carrying the robot between tasks resembles dropping.
    pub fn continue_with(
        &mut self,
        (track, waypoints, wishes): (StepSequence, Waypoints, GraspParameters),
        now: &GraspPose,
        settings: &Settings,
        modules: &mut Modules,
    ) {
        (self.sequence, self.waypoints) = (track, waypoints);
        self.parameters = wishes;
        (self.table, self.recovery, self.ended) = (None, None, false);
        self.regrasp = Regrasp::default();
        (self.meeting_point, self.peer_meeting_point) = (0, 0);
        self.in_hand = InHandMonitor::default();
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
            self.regrasp = Regrasp::default();
            self.enter(0, now, settings, modules);
        }
        self.recovery = None;
    }
}

/// Returns the longest slip of a side whose friction is nearly used up, s.
fn slip_s(percept: &Percept) -> f64 {
    percept
        .sides
        .iter()
        .filter(|finger| finger.utilisation > SLIP_UTILISATION)
        .map(|finger| finger.gross_slip_s)
        .fold(0.0, |most, s| if s > most { s } else { most })
}
