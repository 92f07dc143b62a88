//! Control of one hand, from tactile frames to joint positions, in the order of data flow.

mod borne;
mod grip;
mod telling;

use crate::arbitration::{Arbiter, Intent};
use crate::follow::{CheckedTarget, Lead};
use crate::goal::Goal;
use crate::intake::FrameIntake;
use crate::io::Events;
use crate::kinematics::{HandCommand, HandServo, gap_m};
use crate::modules::{self, Modules, Proposal, Selection, force_up_n};
use crate::perception::{self, ObjectPose, Percept, Perception};
use crate::planning::Waypoints;
use crate::runner::{HandMotion, Outcome, Runner, Wishes};
use crate::settings::Settings;
use crate::tasks::Step;
use crate::tick::Tick;
use crate::wiring::{HandWiring, Wiring};
use borne::Borne;
use nalgebra::{Matrix3, Vector2};
use robot_model::{FINGERS_MAX, HandModel, HandPose, HandVector, VIRTUAL_FINGERS};
use shm_schemas::{
    Cause, EventKind, FingerReport, GraspFigures, Hand, HandFrame, HandReport, HandStatus,
    ModuleEvent, Reason,
};

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
    runner: Option<Runner>,
    intent: Option<Intent>,
    active: u32,
    measured_gap_m: f64,
    /// Measured pose of the object against the hand.
    felt: Option<ObjectPose>,
    base_from_tip: [Matrix3<f64>; FINGERS_MAX],
    frames: u32,
    borne: Borne,
    /// F_2 of the held object, N; zero for an empty hand.
    limit_n: f64,
    /// A module detected slip in the previous tick.
    slides: bool,
}

impl HandControl {
    /// Creates a hand without measurements.
    #[must_use]
    pub(crate) fn new(hand: Hand, model: HandModel, wiring: &Wiring) -> Self {
        // An absent hand requires no sensor.
        let own = &wiring.hands[model.side().index()];
        let own = &HandWiring {
            required: own.required && model.is_present(),
            ..*own
        };
        Self {
            hand,
            required: own.required,
            layout_hash: own.layout.hash(),
            intake: FrameIntake::new(hand, own),
            perception: Perception::new(own, &model),
            borne: Borne::new(&model),
            model,
            modules: Modules::default(),
            arbiter: Arbiter::default(),
            servo: None,
            runner: None,
            intent: None,
            active: 0,
            measured_gap_m: 0.0,
            felt: None,
            base_from_tip: [Matrix3::identity(); FINGERS_MAX],
            frames: 0,
            limit_n: 0.0,
            slides: false,
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
            if let Some(checked) = self.intake.check(frame, tick, &settings.intake) {
                let slides = core::mem::take(&mut self.slides);
                self.perception
                    .update(&checked, slides, &settings.perception);
            }
        }
        self.remember_limit();
        self.publish_touches(&before, settings, events);
        if self.intake.warning().is_some() {
            events.push(ModuleEvent {
                reason: self.intake.warning(),
                ..self.event(EventKind::WARNING)
            });
        }
    }

    /// Returns the reason to hold this hand.
    #[must_use]
    pub(crate) fn hold_reason(&self, tick: Tick, settings: &Settings) -> Reason {
        let of_frames = self.intake.hold_reason(tick, &settings.intake);
        if of_frames.is_some() {
            return of_frames;
        }
        let implausible = self.implausible(settings);
        if implausible.is_some() {
            implausible
        } else {
            self.unconfirmed()
        }
    }

    /// Reports a torque-force mismatch while the hand is busy. At rest, an empty hand may be zeroed
    /// again.
    fn unconfirmed(&self) -> Reason {
        match self.borne.doubt() {
            Some([felt_n, borne_n]) if self.is_busy() => {
                Reason::limit(Cause::FORCE_AGAINST_JOINTS, felt_n, borne_n)
                    .about(self.hand.0 as usize)
            }
            _ => Reason::default(),
        }
    }

    /// Reports an implausible force; opening the fingers in response would drop the object.
    fn implausible(&self, settings: &Settings) -> Reason {
        let limit_n = IMPLAUSIBLE_FACTOR * settings.safety.grip_ceiling_n;
        let fingers = self.perception.percept().fingers.iter();
        let over = |normal_n: &f64| normal_n.is_nan() || normal_n.abs() > limit_n;
        let worst_n = fingers.map(|finger| finger.normal_n).find(over);
        worst_n.map_or(Reason::default(), |n| {
            Reason::limit(Cause::FORCE_IMPLAUSIBLE, n, limit_n).about(self.hand.0 as usize)
        })
    }

    /// Processes the measured hand pose and servo torques, N·m.
    pub(crate) fn locate(
        &mut self,
        measured: &HandPose,
        effort_n_m: Option<&HandVector>,
        settings: &Settings,
        step_s: f64,
    ) {
        let looked_m = self.servo.as_ref().map_or(0.0, HandServo::looked_m);
        self.measured_gap_m = gap_m(measured) + looked_m;
        self.felt = if self.is_busy() && self.model.moves_aside() {
            ObjectPose::felt(&self.model, measured, self.perception.percept())
        } else {
            None
        };
        for (of_tip, tip) in self.base_from_tip.iter_mut().zip(measured.base_from_tip()) {
            *of_tip = tip.rotation;
        }
        let grips = self.grips();
        match effort_n_m {
            Some(effort_n_m) => self.borne.hear(
                &self.model,
                (measured, effort_n_m),
                self.perception.percept(),
                grips,
                &settings.safety,
                step_s,
            ),
            None => self.borne = Borne::new(&self.model),
        }
    }

    /// Synchronises to measured joint positions, rad, at rest.
    pub(crate) fn anchor(&mut self, q_rad: HandVector) {
        self.servo = Some(HandServo::at(&self.model, q_rad));
        self.arbiter.rest();
    }

    /// Passes the client's target, if any, to the executor.
    pub(crate) fn receive_target(&mut self, target: Option<&CheckedTarget>) {
        if let (Some(runner), Some(servo)) = (self.runner.as_mut(), self.servo.as_ref()) {
            let lead = target.map(|target| Lead::of(&self.model, servo.frame(), target));
            runner.receive_lead(lead);
        }
    }

    /// Runs one tick of the task: modules, arbitration, transitions.
    pub(crate) fn act(
        &mut self,
        settings: &Settings,
        step_s: f64,
        events: &mut Events,
    ) -> Option<Outcome> {
        let (runner, servo) = (self.runner.as_mut()?, self.servo.as_mut()?);
        let percept = self.perception.percept();
        let slid = runner.slides().is_some();
        let measured = (self.measured_gap_m, self.felt);
        runner.observe(percept, measured, servo.frame(), step_s);
        let motion = HandMotion {
            carry_scale: self.arbiter.carry_scale(),
            closing_m_s: self.arbiter.closing_m_s(),
            frame: servo.frame(),
            closing_axis: servo.closing_axis(&self.model),
            turns_by_wrist: self.model.turns_by_wrist(),
            base_from_tip: &self.base_from_tip[..self.model.finger_count()],
            tips: perception::compression(&settings.perception, self.model.skin()),
            overread: self.borne.overread(&settings.safety),
            underread: self.borne.underread(&settings.safety),
        };
        let context = runner.context(settings, step_s, motion);
        let proposals = self
            .modules
            .evaluate(runner.step().modules, percept, &context);
        let intent = self.arbiter.merge(&proposals, step_s);
        let down_n = -force_up_n(percept, motion.base_from_tip);
        runner.learn(percept, down_n, intent.finding);
        self.slides = intent.finding.slides;
        let arrived = intent.pose.is_some_and(|c| c.arrived);
        let now = *servo.frame();
        let gave_up = runner.retreats().is_some();
        let slides = runner.slides().filter(|_| !slid);
        let outcome = runner.conclude(
            intent.verdict,
            arrived,
            percept,
            &now,
            settings,
            &mut self.modules,
        );
        self.intent = Some(intent);
        let gives_up = self.runner.as_ref().and_then(Runner::retreats);
        self.warn(slides, events);
        self.warn(gives_up.filter(|_| !gave_up), events);
        self.publish_modules(runner_selection(&self.runner), &proposals, events);
        self.publish_outcome(outcome, events);
        Some(outcome)
    }

    /// Returns the joint set-points: towards the intent if the hand moves, otherwise at rest.
    pub(crate) fn follow(&mut self, moves: bool, step_s: f64) -> HandCommand {
        let Some(servo) = self.servo.as_mut() else {
            return HandCommand {
                q_rad: HandVector::zeros(self.model.joints().len()),
                closing_m_s: [0.0; VIRTUAL_FINGERS],
            };
        };
        match self.intent {
            Some(intent) if moves => {
                servo.follow(&self.model, &intent, self.perception.percept(), step_s)
            }
            _ => {
                let still = servo.rest();
                self.halt();
                still
            }
        }
    }

    /// Stops the hand; motion restarts from zero speed.
    pub(crate) fn halt(&mut self) {
        self.modules.halt();
        self.arbiter.halt();
    }

    /// Adopts the joint positions that the gate let through.
    pub(crate) fn adopt(&mut self, q_rad: HandVector) {
        if let Some(servo) = self.servo.as_mut() {
            servo.adopt(q_rad);
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
        let now = *servo.frame();
        let (waypoints, width_m) = Waypoints::of(&self.model, &now, goal, settings);
        self.arbiter.rest();
        let wishes = Wishes {
            width_m,
            hold_s: request.hold_s,
            // The force limit of a goal applies to the acting hand only.
            max_force_n: if acts { request.max_force_n } else { 0.0 },
        };
        if let Some(runner) = self.runner.as_mut().filter(|runner| runner.grips())
            && acts
            && goal.demands().takes_over
        {
            runner.take_over(
                (track, waypoints, wishes),
                &now,
                settings,
                &mut self.modules,
            );
            return;
        }
        self.modules.reset();
        let runner = Runner::start(track, waypoints, &now, wishes, settings);
        self.runner = Some(runner.with_table(task.table));
    }

    /// Meeting point reached. A hand without a task never delays the other.
    #[must_use]
    pub(crate) fn reached(&self) -> u8 {
        self.runner.as_ref().map_or(u8::MAX, Runner::reached)
    }

    /// Displacement of the held object from its commanded place, base frame, m.
    #[must_use]
    pub(crate) fn displaced_m(&self) -> Vector2<f64> {
        self.runner
            .as_ref()
            .map_or_else(Vector2::zeros, Runner::displaced_m)
    }

    /// Sets the meeting point and the object displacement of the other hand.
    pub(crate) fn receive_peer(&mut self, reached: u8, displaced_m: Vector2<f64>) {
        if let Some(runner) = self.runner.as_mut() {
            runner.receive_peer(reached, displaced_m);
        }
    }

    /// Ends the task. A held object stays held and monitored.
    pub(crate) fn end(&mut self, settings: &Settings) {
        match (self.runner.as_mut(), self.servo.as_ref()) {
            (Some(runner), Some(servo)) if runner.grips() => {
                runner.stand(servo.frame(), settings, &mut self.modules);
            }
            _ => self.abandon(),
        }
    }

    /// Aborts the task, even with an object in hand.
    pub(crate) fn abandon(&mut self) {
        self.runner = None;
        self.active = 0;
        self.arbiter.rest();
    }

    /// Returns true while an executor is active.
    #[must_use]
    pub(crate) fn is_busy(&self) -> bool {
        self.runner.is_some()
    }

    /// Returns true while the hand holds an object.
    #[must_use]
    pub(crate) fn grips(&self) -> bool {
        self.runner.as_ref().is_some_and(Runner::grips)
    }

    /// Executor of the active task.
    #[must_use]
    pub(crate) fn runner(&self) -> Option<&Runner> {
        self.runner.as_ref()
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

fn runner_selection(runner: &Option<Runner>) -> Selection {
    runner
        .as_ref()
        .map_or_else(Selection::default, |r| r.step().modules)
}
