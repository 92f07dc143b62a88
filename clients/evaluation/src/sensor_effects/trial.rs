//! One grasp with a long hold, under one sensor model.

use anyhow::Context;
use atas_client::goal::LIFT_M;
use atas_core::{Controller, Inputs, OperatorRequest, SensorSetup, Settings, Tick};
use atas_tasks::Task;
use atas_tasks::goals::grasp_goal;
use atas_tasks::judge::{SLIP_MAX_M, TURN_MAX_RAD};
use robot_model::RobotModel;
use shm_schemas::{EventKind, GoalRequest, Mode, ObjectTruth};
use sim_backend::{Object, Scene, Sensed, SensorModel, TICK_NS, World};

/// Hold of the goal, s: until the end of the trial.
const HOLD_S: f64 = 70.0;
/// Duration of the watch after the lift, s (acceptance criterion).
const WATCHED_S: f64 = 60.0;
/// Time limit for the lift, s. Design choice: three times the usual time.
const LIFT_LIMIT_S: f64 = 40.0;
/// Ticks until the controller is ready, at most.
const READY_TICKS: u64 = 1000;
/// Share of the lift above which an object counts as lifted.
const LIFTED_SHARE: f64 = 0.5;

/// True outcome after the hold.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Outcome {
    Held,
    Crushed,
    Dropped,
    Slipped,
    NotLifted,
}

/// End of a trial.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Ending {
    pub(super) outcome: Outcome,
    pub(super) warned: bool,
    /// Time of the lift from the start of the simulation, s; the limit if it did not happen.
    pub(super) lifted_s: f64,
}

/// World and goal of a trial, without the sensor model.
pub(super) struct Trial<'a> {
    robot: &'a RobotModel,
    scene: Scene,
    goal: GoalRequest,
    seed: u64,
    settings: Settings,
    torques: bool,
}

/// Controller and world in turn.
struct Run {
    world: Box<World>,
    controller: Box<Controller>,
    sensed: Sensed,
    index: u64,
    torques: bool,
    /// True after the controller became ready; before, HOLD is normal.
    is_ready: bool,
    warned: bool,
}

impl<'a> Trial<'a> {
    pub(super) fn new(
        robot: &'a RobotModel,
        object: Object,
        seed: u64,
        settings: Settings,
        torques: bool,
    ) -> anyhow::Result<Self> {
        let side = robot.acting_side();
        let scene = Task::Grasp.scene(robot, object)?.varied(seed);
        let hint = scene
            .grasp_hint(0)
            .context("a grasp's scene has an object")?;
        Ok(Self {
            robot,
            goal: grasp_goal(&hint, side, LIFT_M, HOLD_S),
            scene,
            seed,
            settings,
            torques,
        })
    }

    /// Runs the grasp and watches the object for a minute after the lift.
    pub(super) fn run(&self, model: &SensorModel) -> anyhow::Result<Ending> {
        let mut scene = self.scene.clone();
        scene.sensor_model = model.clone();
        let mut run = Run {
            world: Box::new(World::new(self.robot, &scene, self.seed)?),
            controller: Box::new(Controller::new(
                self.robot,
                SensorSetup::from_robot(self.robot),
                self.settings,
            )),
            sensed: Sensed::default(),
            index: 0,
            torques: self.torques,
            is_ready: false,
            warned: false,
        };
        for _ in 0..READY_TICKS {
            run.step(None);
            if run.controller.mode().0 == Mode::READY {
                run.is_ready = true;
                break;
            }
        }
        // A drifting sensor may keep the controller from becoming ready: then nothing is lifted.
        let context = run.controller.goal_context(self.robot, &[]);
        let goal = atas_core::check::check(&self.goal, &context);
        let mut request = goal.ok().map(OperatorRequest::Start);
        let (mut lifted_s, mut end_s) = (None, LIFT_LIMIT_S);
        while run.now_s() < end_s {
            run.step(request.take().as_ref());
            if lifted_s.is_none() && run.object().lifted_m >= LIFTED_SHARE * LIFT_M {
                lifted_s = Some(run.now_s());
                end_s = run.now_s() + WATCHED_S;
            }
        }
        if let Some(fault) = run.world.fault() {
            return Err(fault).with_context(|| format!("seed {}", self.seed));
        }
        Ok(Ending {
            outcome: Outcome::of(&run.object()),
            warned: run.warned,
            lifted_s: lifted_s.unwrap_or(LIFT_LIMIT_S),
        })
    }
}

impl Run {
    fn step(&mut self, request: Option<&OperatorRequest>) {
        self.world.sense(&mut self.sensed);
        if !self.torques {
            self.sensed.joints.effort_n_m.fill(0.0);
            self.sensed.joints.seal();
        }
        let [left, right] = &self.sensed.frames;
        let outputs = self.controller.step(&Inputs {
            tick: Tick {
                index: self.index,
                now_ns: self.world.now_ns(),
            },
            frames: [left.as_slice(), right.as_slice()],
            joints: Some(&self.sensed.joints),
            targets: &[],
            request,
        });
        let mut events = outputs.events.as_slice().iter();
        self.warned |= events.any(|event| event.kind == EventKind::WARNING);
        let command = outputs.command;
        self.warned |= self.is_ready && self.controller.mode().0 == Mode::HOLD;
        self.world.advance(Some(&command));
        self.index += 1;
    }

    fn now_s(&self) -> f64 {
        self.world.tick() as f64 * TICK_NS as f64 * 1e-9
    }

    fn object(&self) -> ObjectTruth {
        self.world.truth().objects[0]
    }
}

impl Outcome {
    fn of(object: &ObjectTruth) -> Self {
        let is_steady =
            object.slip_in_hand_m <= SLIP_MAX_M && object.turn_in_hand_rad <= TURN_MAX_RAD;
        if object.crushed != 0 {
            Self::Crushed
        } else if object.dropped != 0 {
            Self::Dropped
        } else if object.lifted_m < LIFTED_SHARE * LIFT_M {
            Self::NotLifted
        } else if is_steady {
            Self::Held
        } else {
            Self::Slipped
        }
    }
}
