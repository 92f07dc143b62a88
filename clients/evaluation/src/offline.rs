//! Offline run: production controller and simulated world in one process and in virtual time.
//!
//! In: a scene, a seed, settings and a goal. Out: a [`Trial`]. No bus, clock or threads: the same
//! arguments give the same bits as the two processes in lock-step.

use atas_core::tasks::Task;
use atas_core::{Controller, Inputs, OperatorRequest, Outputs, SensorSetup, Settings, Tick};
use robot_model::RobotModel;
use shm_schemas::{
    GoalRequest, GoalState, GoalUpdate, GraspTarget, HandFrame, JointCommand, JointState, Mode,
    Reason, WorldTruth,
};
use sim_backend::faults::{Delivery, FaultPipeline};
use sim_backend::{BaseMotion, BaseMotionError, Scene, SceneError, Sensed, TICK_NS, World};

/// Time limit for the controller to become ready, ticks.
const READY_TIMEOUT_TICKS: u64 = 1000;

/// World and controller, on the heap because both are too large for a thread's stack.
pub struct OfflineRun {
    robot: RobotModel,
    world: Box<World>,
    controller: Box<Controller>,
    setup: SensorSetup,
    settings: Settings,
    sensed: Sensed,
    /// Faults between sensors and controller, with what they deliver.
    faults: Option<(FaultPipeline, Delivered)>,
    command: JointCommand,
    /// False: commands do not reach the robot.
    obeys: bool,
    index: u64,
    task: Option<Task>,
    targets: Vec<GraspTarget>,
    /// False: the servos report zero torque.
    has_torques: bool,
}

/// Sensor data of a tick behind the faults.
#[derive(Clone, Debug, Default)]
struct Delivered {
    frames: [Vec<HandFrame>; 2],
    joints: Option<JointState>,
}

/// Result of one goal.
#[derive(Clone, Debug)]
pub struct Trial {
    /// Last goal update that a client would receive.
    pub end: GoalUpdate,
    /// Ground truth before the goal.
    pub start: WorldTruth,
    /// Ground truth at the end.
    pub truth: WorldTruth,
    /// Simulated time, s.
    pub simulated_s: f64,
}

impl OfflineRun {
    /// Creates the world and runs until the controller is READY.
    ///
    /// # Errors
    /// [`SceneError`] if the world cannot be created.
    pub fn new(
        robot: &RobotModel,
        scene: &Scene,
        seed: u64,
        settings: Settings,
    ) -> Result<Self, SceneError> {
        let mut run = Self::without_tick(robot, scene, seed, settings)?;
        run.make_ready(&mut |_| {});
        Ok(run)
    }

    pub(crate) fn make_ready(&mut self, frame_filter: &mut dyn FnMut(&mut HandFrame)) {
        for _ in 0..READY_TIMEOUT_TICKS {
            self.step_filtered(None, &mut *frame_filter);
            if self.controller.mode().0 == Mode::READY {
                break;
            }
        }
    }

    /// Creates the world without running a tick.
    ///
    /// # Errors
    /// [`SceneError`] if the world cannot be created.
    pub fn without_tick(
        robot: &RobotModel,
        scene: &Scene,
        seed: u64,
        settings: Settings,
    ) -> Result<Self, SceneError> {
        let world = World::new(robot, scene, seed)?;
        Ok(Self::in_world(robot, scene, world, settings))
    }

    /// Runs in a world of this scene, without running a tick.
    #[must_use]
    pub fn in_world(robot: &RobotModel, scene: &Scene, world: World, settings: Settings) -> Self {
        let mut setup = SensorSetup::from_robot(robot);
        for (hand, rate_hz) in setup.hands.iter_mut().zip(scene.sensor_rate_hz) {
            hand.rate_hz = f64::from(rate_hz);
        }
        Self {
            robot: robot.clone(),
            world: Box::new(world),
            controller: Box::new(Controller::new(robot, setup, settings)),
            setup,
            settings,
            sensed: Sensed::default(),
            faults: None,
            command: JointCommand::default(),
            obeys: true,
            index: 0,
            task: None,
            targets: Vec::new(),
            has_torques: true,
        }
    }

    /// Lets the servos report zero torque from the next tick on.
    pub(crate) fn hide_torques(&mut self) {
        self.has_torques = false;
    }

    /// Returns a copy in the present state, which continues with the same bits; `None` with an
    /// external engine.
    #[must_use]
    pub fn copy(&self) -> Option<Self> {
        Some(Self {
            robot: self.robot.clone(),
            world: Box::new(self.world.copy()?),
            controller: self.controller.clone(),
            setup: self.setup,
            settings: self.settings,
            sensed: self.sensed.clone(),
            faults: self.faults.clone(),
            command: self.command,
            obeys: self.obeys,
            index: self.index,
            task: self.task,
            targets: self.targets.clone(),
            has_torques: self.has_torques,
        })
    }

    /// Passes all sensor data through these faults from the next tick on.
    pub fn inject(&mut self, faults: FaultPipeline) {
        self.faults = Some((faults, Delivered::default()));
    }

    /// Commands do not reach the robot from the next tick on.
    pub fn disconnect_robot(&mut self) {
        self.obeys = false;
    }

    /// Advances the world without the controller, as while its process is stopped.
    pub fn pause_controller(&mut self, ticks: u64) {
        for _ in 0..ticks {
            self.world.sense(&mut self.sensed);
            self.world.advance(None);
            self.index += 1;
        }
    }

    /// Replaces the controller by a new one with another writer epoch, as after the death of its
    /// process.
    pub fn restart_controller(&mut self) {
        self.setup.writer_epoch += 1;
        *self.controller = Controller::new(&self.robot, self.setup, self.settings);
    }

    /// Returns the number of ticks so far.
    #[must_use]
    pub fn ticks(&self) -> u64 {
        self.index
    }

    /// Sets an additional task for goals that name it.
    pub fn set_task(&mut self, task: Option<Task>) {
        self.task = task;
    }

    /// Adds an external reference for the next tick (`teleop` goal).
    pub fn push_target(&mut self, target: GraspTarget) {
        self.targets.push(target);
    }

    /// Sets the motion of the robot's base; see [`World::set_base_motion`].
    ///
    /// # Errors
    /// [`BaseMotionError`] if the motion exceeds the limits of a base, or the engine has no moving
    /// base.
    pub fn set_base_motion(&mut self, ride: &BaseMotion) -> Result<(), BaseMotionError> {
        self.world.set_base_motion(ride)
    }

    /// Validates a goal and returns the request that starts it.
    ///
    /// # Errors
    /// [`Reason`] for the rejection.
    pub fn request(&self, goal: &GoalRequest) -> Result<OperatorRequest, Reason> {
        let now = self
            .controller
            .goal_context(&self.robot, self.task.as_slice());
        atas_core::check::check(goal, &now).map(OperatorRequest::Start)
    }

    /// Runs one tick: sense, control, move.
    pub fn step(&mut self, request: Option<&OperatorRequest>) -> &Outputs {
        self.step_filtered(request, |_| {})
    }

    /// Runs one tick; `frame_filter` may modify each tactile frame and must re-seal it.
    pub fn step_filtered(
        &mut self,
        request: Option<&OperatorRequest>,
        mut frame_filter: impl FnMut(&mut HandFrame),
    ) -> &Outputs {
        self.world.sense(&mut self.sensed);
        if !self.has_torques {
            self.sensed.joints.effort.fill(0.0);
            self.sensed.joints.seal();
        }
        self.sensed
            .frames
            .iter_mut()
            .flatten()
            .for_each(&mut frame_filter);
        let tick = Tick {
            index: self.index,
            now_ns: self.world.now_ns(),
        };
        let (frames, joints) = match &mut self.faults {
            None => (
                self.sensed.frames.each_ref().map(Option::as_slice),
                Some(&self.sensed.joints),
            ),
            Some((faults, delivered)) => {
                delivered.receive(faults, self.index, &self.sensed);
                let frames = delivered.frames.each_ref().map(Vec::as_slice);
                (frames, delivered.joints.as_ref())
            }
        };
        let outputs = self.controller.step(&Inputs {
            tick,
            frames,
            joints,
            targets: &self.targets,
            request,
        });
        self.targets.clear();
        self.command = outputs.command;
        self.world
            .advance(Some(&self.command).filter(|_| self.obeys));
        self.index += 1;
        outputs
    }

    /// Runs a goal to its end, for at most `limit_s`; calls `watch` every tick. A rejected goal
    /// ends at once.
    pub fn run(
        &mut self,
        goal: &GoalRequest,
        limit_s: f64,
        watch: impl FnMut(&Outputs, &World),
    ) -> Trial {
        self.run_filtered(goal, limit_s, &mut |_| {}, watch)
    }

    pub(crate) fn run_filtered(
        &mut self,
        goal: &GoalRequest,
        limit_s: f64,
        frame_filter: &mut dyn FnMut(&mut HandFrame),
        mut watch: impl FnMut(&Outputs, &World),
    ) -> Trial {
        let (first, start) = (self.index, self.world.truth());
        let end = self.pursue(goal, limit_s, frame_filter, &mut watch);
        Trial {
            end,
            start,
            truth: self.world.truth(),
            simulated_s: (self.index - first) as f64 * TICK_NS as f64 * 1e-9,
        }
    }

    fn pursue(
        &mut self,
        goal: &GoalRequest,
        limit_s: f64,
        frame_filter: &mut dyn FnMut(&mut HandFrame),
        watch: &mut impl FnMut(&Outputs, &World),
    ) -> GoalUpdate {
        let ended = |state, reason: Reason| GoalUpdate {
            state,
            reason: reason.into(),
            ..GoalUpdate::default()
        };
        let mut order = match self.request(goal) {
            Ok(order) => Some(order),
            Err(reason) => return ended(GoalState::REJECTED, reason),
        };
        for _ in 0..(limit_s * 1e9) as u64 / TICK_NS {
            let outputs = *self.step_filtered(order.take().as_ref(), &mut *frame_filter);
            watch(&outputs, &self.world);
            let is_end = |u: &GoalUpdate| u.goal_id == goal.goal_id && u.state.is_final();
            if let Some(end) = outputs.goal_update.filter(is_end) {
                return end;
            }
            if self.world.fault().is_some() {
                break;
            }
        }
        let reason = Reason::TimedOut {
            elapsed_s: limit_s,
            limit_s,
        };
        ended(GoalState::FAILED, reason)
    }

    /// Returns the world, for evaluation.
    #[must_use]
    pub fn world(&self) -> &World {
        &self.world
    }

    /// Returns the world, to load objects and bump arms.
    pub(crate) fn world_mut(&mut self) -> &mut World {
        &mut self.world
    }

    /// Returns the sensor data of the last tick.
    #[must_use]
    pub fn sensed(&self) -> &Sensed {
        &self.sensed
    }

    /// Returns the controller.
    #[must_use]
    pub fn controller(&self) -> &Controller {
        &self.controller
    }
}

impl Delivered {
    /// Takes the data of a tick behind the faults. Of several joint states, the newest counts.
    fn receive(&mut self, faults: &mut FaultPipeline, tick: u64, sensed: &Sensed) {
        self.frames.iter_mut().for_each(Vec::clear);
        self.joints = None;
        faults.pass(tick, sensed, |delivery| match delivery {
            Delivery::Frame(side, frame) => self.frames[side.index()].push(*frame),
            Delivery::Joints(joints) => self.joints = Some(*joints),
        });
    }
}
