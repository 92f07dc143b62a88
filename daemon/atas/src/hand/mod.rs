//! Control of one hand, from tactile frames to joint positions, in the order of data flow.

mod grip;
mod reporting;
mod torque_force_check;

use crate::arbitration::{Arbiter, Intent};
use crate::executor::{GraspParameters, HandMotion, Outcome, TaskExecutor};
use crate::goal::Goal;
use crate::held_object::LiftFinding;
use crate::intake::FrameIntake;
use crate::io::Events;
use crate::kinematics::{HandCommand, HandServo, gap_m};
use crate::modules::{self, Modules, Proposal, Selection};
use crate::perception::{self, ObjectPose, Percept, Perception};
use crate::planning::Waypoints;
use crate::sensor_setup::{HandSensorSetup, SensorSetup};
use crate::settings::Settings;
use crate::tasks::Step;
use crate::teleop::{TeleopTarget, ValidatedTarget};
use crate::tick::Tick;
use nalgebra::{Vector2, Vector3};
use robot_model::{FINGERTIPS_MAX, HandModel, HandPose, HandVector, PerSide, Transform};
use shm_schemas::{
    EventKind, FingerReport, GraspFigures, Hand, HandFrame, HandReport, HandStatus, ModuleEvent,
    Reason,
};
use torque_force_check::TorqueForceCheck;

/// Multiple of the grip ceiling beyond which a force is implausible (design choice: the gate stops
/// a finger at the ceiling).
const IMPLAUSIBLE_FACTOR: f64 = 2.0;

#[derive(Clone, Copy, Debug)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct HandControl {
    hand: Hand,
    model: HandModel,
    required: bool,
    layout_hash: u64,
    pub(crate) intake: FrameIntake,
    perception: Perception,
    modules: Modules,
    arbiter: Arbiter,
    servo: Option<HandServo>,
    executor: Option<TaskExecutor>,
    intent: Option<Intent>,
    active_modules: u32,
    measured_gap_m: f64,
    /// Measured pose of the object against the hand.
    object_pose: Option<ObjectPose>,
    base_from_tip: [Transform; FINGERTIPS_MAX],
    side_m: PerSide<Vector3<f64>>,
    frames: u32,
    torque_check: TorqueForceCheck,
    /// F_2 of the held object, N; zero for an empty hand.
    force_limit_n: f64,
    /// A module detected slip in the previous tick.
    slips: bool,
}

impl HandControl {
    /// Creates a hand without measurements.
    #[must_use]
    pub(crate) fn new(hand: Hand, model: HandModel, wiring: &SensorSetup) -> Self {
        // An absent hand requires no sensor.
        let own = &wiring.hands[model.side().index()];
        let own = &HandSensorSetup {
            required: own.required && model.is_present(),
            ..*own
        };
        Self {
            hand,
            required: own.required,
            layout_hash: own.layout.hash(),
            intake: FrameIntake::new(hand, own),
            perception: Perception::new(own, &model),
            torque_check: TorqueForceCheck::new(&model),
            model,
            modules: Modules::default(),
            arbiter: Arbiter::default(),
            servo: None,
            executor: None,
            intent: None,
            active_modules: 0,
            measured_gap_m: 0.0,
            object_pose: None,
            base_from_tip: [Transform::IDENTITY; FINGERTIPS_MAX],
            side_m: PerSide::repeat(Vector3::zeros()),
            frames: 0,
            force_limit_n: 0.0,
            slips: false,
        }
    }

    /// Processes the frames of this tick.
    pub(crate) fn update(
        &mut self,
        frames: &[HandFrame],
        tick: Tick,
        settings: &Settings,
        events: &mut Events,
    ) {
        let before = *self.perception.percept();
        self.intent = None;
        self.intake.begin();
        self.perception.begin();
        self.frames = frames.len() as u32;
        for frame in frames {
            if let Some(checked) = self.intake.validate(frame, tick, &settings.intake) {
                let slides = core::mem::take(&mut self.slips);
                self.perception.update(&checked, slides, settings);
            }
        }
        if let Some(moves_freely) = self.expects_no_load() {
            self.perception
                .track_zero(moves_freely, &settings.perception);
        }
        self.update_force_limit();
        self.publish_contacts(&before, settings, events);
        if self.intake.warning().is_some() {
            events.push(ModuleEvent {
                reason: self.intake.warning().into(),
                ..self.event(EventKind::WARNING)
            });
        }
    }

    /// Returns `Some` while nothing loads the fingertips until they touch: true in free motion,
    /// where a touch is an obstacle.
    fn expects_no_load(&self) -> Option<bool> {
        match &self.executor {
            None => Some(false),
            Some(executor) if executor.moves_freely() => Some(true),
            // A client may close the fingers more slowly than a sensor drifts.
            Some(executor) if executor.is_teleoperated() => None,
            Some(executor) => executor.searches().then_some(false),
        }
    }

    /// Returns the reason to hold this hand.
    #[must_use]
    pub(crate) fn hold_reason(&self, tick: Tick, settings: &Settings) -> Reason {
        let of_frames = self.intake.hold_reason(tick, &settings.intake);
        if of_frames.is_some() {
            return of_frames;
        }
        let implausible = self.implausible_force(settings);
        if implausible.is_some() {
            implausible
        } else {
            self.torque_mismatch()
        }
    }

    /// Reports a torque-force mismatch while the hand is busy. At rest, an empty hand may be zeroed
    /// again.
    fn torque_mismatch(&self) -> Reason {
        match self.torque_check.mismatch() {
            Some([tactile_n, joint_estimated_n]) if self.is_busy() => Reason::ForceAgainstJoints {
                hand: self.hand,
                tactile_n,
                joint_estimated_n,
            },
            _ => Reason::None,
        }
    }

    /// Reports an implausible force; opening the fingers in response would drop the object.
    fn implausible_force(&self, settings: &Settings) -> Reason {
        let limit_n = IMPLAUSIBLE_FACTOR * settings.safety.grip_ceiling_n;
        let fingers = self.perception.percept().fingertips.iter();
        let over = |normal_n: &f64| normal_n.is_nan() || normal_n.abs() > limit_n;
        let worst_n = fingers.map(|finger| finger.normal_n).find(over);
        worst_n.map_or(Reason::None, |force_n| Reason::ForceImplausible {
            hand: self.hand,
            force_n,
            limit_n,
        })
    }

    /// Processes the measured hand pose and servo torques, N·m or N.
    pub(crate) fn update_measured(
        &mut self,
        measured: &HandPose,
        effort: Option<&HandVector>,
        settings: &Settings,
        step_s: f64,
    ) {
        let looked_m = self.servo.as_ref().map_or(0.0, HandServo::contact_search_m);
        self.measured_gap_m = gap_m(measured) + looked_m;
        self.object_pose = if self.is_busy() && self.model.has_lateral_shift() {
            ObjectPose::estimate(&self.model, measured, self.perception.percept())
        } else {
            None
        };
        for (of_tip, tip) in self.base_from_tip.iter_mut().zip(measured.base_from_tip()) {
            *of_tip = *tip;
        }
        self.side_m = PerSide::from_fn(|side| measured.side_m(side));
        let closing_s = self.executor.as_ref().map_or(0.0, TaskExecutor::closing_s);
        let load = (self.grips(), closing_s);
        match effort {
            Some(effort) => self.torque_check.update(
                &self.model,
                (measured, effort),
                self.perception.percept(),
                load,
                &settings.safety,
                step_s,
            ),
            None => self.torque_check = TorqueForceCheck::new(&self.model),
        }
    }

    /// Synchronises to measured joint positions, rad or m, at rest.
    pub(crate) fn synchronise(&mut self, q: HandVector) {
        self.servo = Some(HandServo::new(&self.model, q));
        self.arbiter.reset();
    }

    /// Passes the client's target, if any, to the executor.
    pub(crate) fn receive_target(&mut self, target: Option<&ValidatedTarget>) {
        if let (Some(runner), Some(servo)) = (self.executor.as_mut(), self.servo.as_ref()) {
            let lead = target.map(|target| TeleopTarget::new(&self.model, servo.pose(), target));
            runner.receive_target(lead);
        }
    }

    /// Runs one tick of the task: modules, arbitration, transitions.
    pub(crate) fn run_task(
        &mut self,
        settings: &Settings,
        step_s: f64,
        events: &mut Events,
    ) -> Option<Outcome> {
        let (runner, servo) = (self.executor.as_mut()?, self.servo.as_mut()?);
        let percept = self.perception.percept();
        let slid = runner.slip_warning().is_some();
        let drifted = runner.object().drift_warning(self.hand).is_some();
        let hand = HandMotion {
            carry_scale: self.arbiter.carry_scale(),
            closing_m_s: self.arbiter.closing_m_s(),
            pose: servo.pose(),
            closing_axis: servo.closing_axis(&self.model),
            turns_by_wrist: self.model.turns_by_wrist(),
            base_from_tip: &self.base_from_tip[..self.model.fingertip_count()],
            side_m: self.side_m,
            compression: perception::compression(&settings.perception, self.model.skin()),
            tactile_over_torque: self.torque_check.tactile_over_torque(&settings.safety),
            torque_over_tactile: self.torque_check.torque_over_tactile(&settings.safety),
        };
        let measured = (self.measured_gap_m, self.object_pose);
        runner.update_measured(percept, &hand, measured, settings, step_s);
        let context = runner.context(settings, step_s, &hand);
        let proposals = self
            .modules
            .evaluate(runner.step().modules, percept, &context);
        self.slips = context.object.drops;
        let intent = self.arbiter.merge(&proposals, step_s);
        self.slips |= intent.finding == LiftFinding::Standing;
        runner.receive_finding(intent.finding);
        let arrived = intent.pose.is_some_and(|c| c.arrived);
        let now = *servo.pose();
        let drifts = runner
            .object()
            .drift_warning(self.hand)
            .filter(|_| !drifted);
        let gave_up = runner.recovery_reason().is_some();
        let slides = runner.slip_warning().filter(|_| !slid);
        let outcome = runner.finish_tick(
            intent.verdict,
            arrived,
            percept,
            &now,
            settings,
            &mut self.modules,
        );
        self.intent = Some(intent);
        let gives_up = self
            .executor
            .as_ref()
            .and_then(TaskExecutor::recovery_reason);
        self.warn(slides, events);
        self.warn(drifts, events);
        self.warn(gives_up.filter(|_| !gave_up), events);
        self.publish_modules(executor_selection(&self.executor), &proposals, events);
        self.publish_outcome(outcome, events);
        Some(outcome)
    }

    /// Returns the joint set-points: towards the intent if the hand moves, otherwise at rest.
    pub(crate) fn command(&mut self, moves: bool, step_s: f64) -> HandCommand {
        let Some(servo) = self.servo.as_mut() else {
            return HandCommand {
                q: HandVector::zeros(self.model.joints().len()),
                closing_m_s: PerSide::repeat(0.0),
            };
        };
        match self.intent {
            Some(intent) if moves => {
                servo.update(&self.model, &intent, self.perception.percept(), step_s)
            }
            _ => {
                let still = servo.hold_still();
                self.halt();
                still
            }
        }
    }

    /// Stops the hand; motion restarts from zero speed.
    pub(crate) fn halt(&mut self) {
        self.modules.stop();
        self.arbiter.stop();
    }

    /// Adopts the joint positions that the gate let through.
    pub(crate) fn adopt(&mut self, q: HandVector) {
        if let Some(servo) = self.servo.as_mut() {
            servo.accept(q);
        }
    }

    /// Starts this hand's part of a task.
    pub(crate) fn start(&mut self, goal: &Goal, settings: &Settings) {
        let (request, task) = (goal.request(), goal.task());
        let acts = self.model.side() == goal.side();
        let track = if acts {
            Some(task.acting)
        } else {
            task.helping
        };
        let (Some(servo), Some(track)) = (self.servo.as_ref(), track) else {
            return;
        };
        let now = *servo.pose();
        let (waypoints, width_m) = Waypoints::for_goal(&self.model, &now, goal, settings);
        self.arbiter.reset();
        let wishes = GraspParameters {
            width_m,
            hold_s: request.hold_s,
            // The force limit of a goal applies to the acting hand only.
            max_force_n: if acts { request.max_force_n } else { 0.0 },
        };
        if let Some(runner) = self.executor.as_mut().filter(|runner| runner.grips())
            && acts
            && goal.requirements().starts_with_object
        {
            runner.continue_with(
                (track, waypoints, wishes),
                &now,
                settings,
                &mut self.modules,
            );
            return;
        }
        self.modules.reset();
        let runner = TaskExecutor::start(track, waypoints, &now, wishes, settings);
        self.executor = Some(runner.with_table(task.table));
    }

    /// Meeting point reached. A hand without a task never delays the other.
    #[must_use]
    pub(crate) fn meeting_point(&self) -> u8 {
        self.executor
            .as_ref()
            .map_or(u8::MAX, TaskExecutor::meeting_point)
    }

    /// Displacement of the held object from its commanded place, base frame, m.
    #[must_use]
    pub(crate) fn displacement_m(&self) -> Vector2<f64> {
        self.executor
            .as_ref()
            .map_or_else(Vector2::zeros, TaskExecutor::displacement_m)
    }

    /// Sets the meeting point and the object displacement of the other hand.
    pub(crate) fn receive_peer(&mut self, reached: u8, displaced_m: Vector2<f64>) {
        if let Some(runner) = self.executor.as_mut() {
            runner.receive_peer(reached, displaced_m);
        }
    }

    /// Ends the task. A held object stays held and monitored.
    pub(crate) fn end_task(&mut self, settings: &Settings) {
        match (self.executor.as_mut(), self.servo.as_ref()) {
            (Some(runner), Some(servo)) if runner.grips() => {
                runner.hold_object(servo.pose(), settings, &mut self.modules);
            }
            _ => self.abort_task(),
        }
    }

    /// Aborts the task, even with an object in hand.
    pub(crate) fn abort_task(&mut self) {
        self.executor = None;
        self.active_modules = 0;
        self.arbiter.reset();
    }

    /// Returns true while an executor is active.
    #[must_use]
    pub(crate) fn is_busy(&self) -> bool {
        self.executor.is_some()
    }

    /// Returns true while the hand holds an object.
    #[must_use]
    pub(crate) fn grips(&self) -> bool {
        self.executor.as_ref().is_some_and(TaskExecutor::grips)
    }

    /// Executor of the active task.
    #[must_use]
    pub(crate) fn executor(&self) -> Option<&TaskExecutor> {
        self.executor.as_ref()
    }

    /// Takes the present tactile reading as zero.
    pub(crate) fn bias(&mut self) {
        self.perception.bias();
    }

    /// Model of this hand.
    #[must_use]
    pub(crate) fn model(&self) -> &HandModel {
        &self.model
    }
}

fn executor_selection(runner: &Option<TaskExecutor>) -> Selection {
    runner
        .as_ref()
        .map_or_else(Selection::default, |r| r.step().modules)
}
