//! Task executor: runs the steps of one hand's task and stores its measurements.

mod in_hand;
mod led;
mod proof;
mod regrasp;
mod transitions;

use self::in_hand::InHand;
use self::proof::Proof;
use self::regrasp::Regrasp;
use crate::follow::Lead;
use crate::modules::{Context, Finding, Modules, RELEASE_SHARE, Verdict, force_range_n};
use crate::path::Path;
use crate::perception::{ObjectPose, Percept, StiffnessFit};
use crate::planning::{Waypoints, path_of};
use crate::settings::Settings;
use crate::tasks::{
    BACK_OUT, BehaviourTable, KEEP, Motion, RAISE, STAND, STAND_LED, Step, Track, Transition,
    WITHDRAW,
};
use crate::thresholds::Thresholds;
use nalgebra::{Matrix3, Vector2, Vector3};
use robot_model::{Compression, GraspFrame, VIRTUAL_FINGERS};
use shm_schemas::{Cause, ModuleId, Reason};

/// Contact loss of a gripped object until it counts as lost, s (design choice: longer than contact
/// bounce).
const LOST_AFTER_S: f64 = 0.05;
/// Slip duration on one side before a warning, s (design choice: several times the response time of
/// Module 2).
const SLIDES_AFTER_S: f64 = 0.1;
/// Slip duration on both sides, or drop duration, at F_2 before the object is put back, s (design
/// choice).
const SPENT_AFTER_S: f64 = 0.03;
/// Friction utilisation below which slip is ignored (design choice): a light load on a firm grip is
/// noise.
const SLIDES_ABOVE: f64 = 0.9;
/// Half opening at which any search ends, m (design choice): the fingertips meet below it.
const MEET_M: f64 = 0.001;

/// Motion of the hand at the start of a tick.
#[derive(Clone, Copy, Debug)]
pub struct HandMotion<'a> {
    /// Path speed factor arbitrated in the previous tick.
    pub carry_scale: f64,
    /// Closing speed per grasp side arbitrated in the previous tick, m/s.
    pub closing_m_s: [f64; VIRTUAL_FINGERS],
    /// Commanded grasp pose.
    pub frame: &'a GraspFrame,
    /// Current closing axis, base frame, unit length.
    pub closing_axis: Vector3<f64>,
    /// See [`Context::turns_by_wrist`].
    pub turns_by_wrist: bool,
    /// Measured orientation of each fingertip.
    pub base_from_tip: &'a [Matrix3<f64>],
    /// Compression of the fingertips under load.
    pub tips: Compression,
    /// Ratio of tactile to torque-estimated force, ≥ 1.
    pub overread: f64,
    /// Ratio of torque-estimated to tactile force, ≥ 1.
    pub underread: f64,
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
pub struct Wishes {
    /// Expected width along the closing axis, m.
    pub width_m: f64,
    /// Hold time, s.
    pub hold_s: f64,
    /// Maximum grip force, N; zero if not given.
    pub max_force_n: f64,
}

impl Wishes {
    /// Parameters for an object found in the hand.
    const FOUND: Self = Self {
        width_m: 0.0,
        hold_s: f64::INFINITY,
        max_force_n: 0.0,
    };

    /// Returns F_1 and F_2 before the first touch.
    fn thresholds_before_touch(&self, settings: &Settings) -> Thresholds {
        Thresholds::unknown(&settings.grasp).told(self.max_force_n, &settings.grasp)
    }
}

/// Task state of one hand.
#[derive(Clone, Copy, Debug)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Runner {
    track: Track,
    table: Option<BehaviourTable>,
    index: usize,
    step_s: f64,
    path: Path,
    waypoints: Waypoints,
    wishes: Wishes,
    thresholds: Thresholds,
    stiffness: Option<StiffnessFit>,
    all_touched: bool,
    touched_at_m: f64,
    closing_m: f64,
    lifted_from_m: Option<Vector3<f64>>,
    carried_m: f64,
    hangs: bool,
    tries: bool,
    proof: Proof,
    in_hand: InHand,
    /// Duration of dropping, s.
    sinks_s: f64,
    ended: bool,
    out_of_touch_s: f64,
    slides: Option<Reason>,
    holds: bool,
    /// The object was found in the hand. Its origin is unknown, so it is never put back.
    found: bool,
    reached: u8,
    peer_reached: u8,
    felt: Option<ObjectPose>,
    regrasp: Regrasp,
    /// Displacement of the object from its commanded place, base frame, m.
    displaced_m: Vector2<f64>,
    lead: Option<Lead>,
    /// Opening at the start of a teleoperated grip, later at the touch of all sides, m.
    touched_opening_m: f64,
    retreat: Option<(Retreat, Reason)>,
}

/// Recovery from a task that cannot continue.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
enum Retreat {
    /// Puts the object back at its source.
    PutBack,
    /// Lifts the object again and holds it.
    Raise,
    /// Withdraws from an obstacle.
    Withdraw,
}

impl Runner {
    /// Starts a task at the present pose.
    #[must_use]
    pub fn start(
        track: Track,
        waypoints: Waypoints,
        now: &GraspFrame,
        wishes: Wishes,
        settings: &Settings,
    ) -> Self {
        let mut runner = Self {
            track,
            table: None,
            index: 0,
            step_s: 0.0,
            path: Path::stay(*now),
            waypoints,
            wishes,
            thresholds: wishes.thresholds_before_touch(settings),
            stiffness: None,
            all_touched: false,
            touched_at_m: 0.0,
            closing_m: 0.0,
            lifted_from_m: None,
            carried_m: 0.0,
            hangs: false,
            tries: false,
            proof: Proof::default(),
            in_hand: InHand::default(),
            sinks_s: 0.0,
            ended: false,
            out_of_touch_s: 0.0,
            slides: None,
            holds: false,
            found: false,
            reached: 0,
            peer_reached: 0,
            felt: None,
            regrasp: Regrasp::default(),
            displaced_m: Vector2::zeros(),
            lead: None,
            touched_opening_m: 0.0,
            retreat: None,
        };
        runner.path = runner.plan(now, settings);
        runner.arrive();
        runner
    }

    /// Returns the executor with a table for the behaviour table module.
    #[must_use]
    pub fn with_table(self, table: Option<BehaviourTable>) -> Self {
        Self { table, ..self }
    }

    /// Holds an object found in the hand, with its reported F_2, N, or zero if unknown.
    #[must_use]
    pub fn keep(
        waypoints: Waypoints,
        now: &GraspFrame,
        percept: &Percept,
        told_f2_n: f64,
        settings: &Settings,
    ) -> Self {
        let (weakest_n, strongest_n) = force_range_n(percept);
        Self {
            thresholds: Thresholds::found([weakest_n, strongest_n], told_f2_n, &settings.grasp),
            all_touched: true,
            lifted_from_m: Some(now.centre_m),
            holds: true,
            found: true,
            ..Self::start(KEEP, waypoints, now, Wishes::FOUND, settings)
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

    /// Carried distance, m.
    #[must_use]
    pub fn carried_m(&self) -> f64 {
        self.carried_m
    }

    /// Warning reason if the object in the hand slips.
    #[must_use]
    pub fn slides(&self) -> Option<Reason> {
        self.slides
    }

    /// Reason of the recovery in progress.
    #[must_use]
    pub fn retreats(&self) -> Option<Reason> {
        self.retreat.map(|(_, reason)| reason)
    }

    /// Last meeting point reached.
    #[must_use]
    pub fn reached(&self) -> u8 {
        self.reached
    }

    /// Returns true if the hand grips an object.
    #[must_use]
    pub fn grips(&self) -> bool {
        self.holds && self.out_of_touch_s <= LOST_AFTER_S
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
            least_n: self.least_n(settings),
            all_touched: self.all_touched,
            closing_m: self.closing_m,
            tips: motion.tips,
            carried_m: self.carried_m,
            hangs: self.hangs || !self.step().modules.contains(ModuleId::LOAD_TEST),
            tries: self.tries,
            proved: self.proof.stands(),
            table: self.table.as_ref(),
            path: &self.path,
            carry_scale: motion.carry_scale,
            closing_m_s: motion.closing_m_s,
            frame: motion.frame,
            closing_axis: motion.closing_axis,
            turns_by_wrist: motion.turns_by_wrist,
            base_from_tip: motion.base_from_tip,
            overread: motion.overread,
            underread: motion.underread,
            turning: self.waypoints.turning(),
            lowering_m: match self.step().motion {
                Motion::Lower => Some(self.waypoints.lowering_m()),
                Motion::Follow => self.led_down_m(motion.frame),
                _ => None,
            },
            lead: self
                .lead
                .as_ref()
                .filter(|_| self.step().motion == Motion::Follow),
        }
    }

    /// Returns the minimum grip force, N: F_1 at first touch, lower for a carried object.
    fn least_n(&self, settings: &Settings) -> f64 {
        let carries = self.holds && self.lifted_from_m.is_some();
        let keep_n = settings.grasp.keep_n;
        if carries && keep_n < self.thresholds.f1_n {
            keep_n
        } else {
            self.thresholds.f1_n
        }
    }

    /// Processes the module findings; `down_n` is the vertical load on the fingers, N.
    pub fn learn(&mut self, percept: &Percept, down_n: f64, finding: Finding) {
        self.proof.follow(percept);
        if finding.hangs && !self.hangs {
            self.proof.prove();
        }
        self.hangs |= finding.hangs;
        self.tries = finding.tries;
        let sinks = finding.slides && self.hangs;
        self.sinks_s = if sinks {
            self.sinks_s + percept.step_s
        } else {
            0.0
        };
        let carries = self.holds && self.lifted_from_m.is_some() && !self.found;
        // A teleoperated hand may place its object at any time.
        if carries && self.step().motion != Motion::Lower && !self.is_led() {
            let is_tested = self.step().modules.contains(ModuleId::LOAD_TEST);
            let facts = (finding, self.hangs, is_tested);
            self.in_hand.follow(percept, down_n, self.carried_m, facts);
        }
    }

    /// Sets the meeting point and the object displacement of the other hand.
    pub fn receive_peer(&mut self, reached: u8, displaced_m: Vector2<f64>) {
        self.peer_reached = reached;
        self.waypoints.displace_target(displaced_m);
    }

    /// Updates contact, closing and carried distance before the modules run. Inputs: fingertip
    /// distance, m, object pose, and commanded pose `now`.
    pub fn observe(
        &mut self,
        percept: &Percept,
        (gap_m, felt): (f64, Option<ObjectPose>),
        now: &GraspFrame,
        step_s: f64,
    ) {
        self.step_s += step_s;
        self.felt = felt;
        let touching = percept.virtual_fingers.iter().all(|f| f.in_contact);
        if touching && !self.all_touched && self.step().transition == Transition::AllTouched {
            self.all_touched = true;
            self.touched_at_m = gap_m;
            self.touched_opening_m = now.half_opening_m.iter().sum();
        }
        self.closing_m = self.touched_at_m - gap_m;
        if let Some(from_m) = self.lifted_from_m {
            self.carried_m = (now.centre_m - from_m).norm();
        }
        self.slides = self.sliding(percept);
        self.out_of_touch_s = if touching {
            0.0
        } else {
            self.out_of_touch_s + step_s
        };
    }

    /// Returns the warning reason if a held object slips.
    fn sliding(&self, percept: &Percept) -> Option<Reason> {
        let held = self.step().transition == Transition::Held && self.grips();
        let slid_s = percept
            .virtual_fingers
            .iter()
            .filter(|finger| finger.utilisation > SLIDES_ABOVE)
            .map(|finger| finger.gross_slip_s)
            .fold(0.0, |most, s| if s > most { s } else { most })
            .min(self.proof.lapsed_s());
        (held && slid_s > SLIDES_AFTER_S)
            .then(|| Reason::limit(Cause::SLIDING, slid_s, SLIDES_AFTER_S))
    }

    /// Returns the reason to put back an object that slips despite F_2.
    fn out_of_force(&self, percept: &Percept) -> Option<Reason> {
        let (_, strongest_n) = force_range_n(percept);
        let f2_n = self.thresholds.f2_n;
        let everywhere = percept
            .virtual_fingers
            .iter()
            .all(|finger| finger.gross_slip_s > SPENT_AFTER_S);
        let slides = (self.slides.is_some() && everywhere) || self.sinks_s > SPENT_AFTER_S;
        let spent = slides && strongest_n > RELEASE_SHARE * f2_n;
        let reason = Reason::limit(Cause::OUT_OF_FORCE, strongest_n, f2_n);
        (spent && self.retreat.is_none() && !self.found).then(|| reason.by(ModuleId::FORCE_LIMIT))
    }
}

impl Runner {
    /// Continues with a task for the object in the hand; its thresholds and stiffness stay. In-hand
    /// monitoring restarts, because carrying the robot between tasks resembles dropping.
    pub fn take_over(
        &mut self,
        (track, waypoints, wishes): (Track, Waypoints, Wishes),
        now: &GraspFrame,
        settings: &Settings,
        modules: &mut Modules,
    ) {
        (self.track, self.waypoints) = (track, waypoints);
        self.wishes = wishes;
        (self.table, self.retreat, self.ended) = (None, None, false);
        self.regrasp = Regrasp::default();
        (self.reached, self.peer_reached) = (0, 0);
        self.in_hand = InHand::default();
        self.enter(0, now, settings, modules);
    }

    /// Switches to holding when a goal ends with an object in hand.
    pub fn stand(&mut self, now: &GraspFrame, settings: &Settings, modules: &mut Modules) {
        if self.step().transition != Transition::Held {
            self.track = if self.is_led() { STAND_LED } else { STAND };
            self.regrasp = Regrasp::default();
            self.enter(0, now, settings, modules);
        }
        self.retreat = None;
    }
}
