//! Offline run: production controller and simulated world in one process and in virtual time.
//!
//! In: a scene, a seed, settings and a goal. Out: a [`Trial`]. No bus, clock or threads: the same
//! arguments give the same bits as the two processes in lock-step.

use atas_core::tasks::Task;
use atas_core::{Controller, Inputs, OperatorRequest, Outputs, SensorSetup, Settings, Tick};
use robot_model::RobotModel;
use shm_schemas::{
    GoalRequest, GoalState, GoalUpdate, GraspTarget, HandFrame, JointCommand, Mode, Reason,
    WorldTruth,
};
use sim_backend::{BaseMotion, BaseMotionError, Scene, SceneError, Sensed, TICK_NS, World};

/// Time limit for the controller to become ready, ticks.
const READY_TIMEOUT_TICKS: u64 = 1000;

/// World and controller, on the heap because both are too large for a thread's stack.
pub struct OfflineRun {
    robot: RobotModel,
    world: Box<World>,
    controller: Box<Controller>,
    sensed: Sensed,
    command: JointCommand,
    index: u64,
    task: Option<Task>,
    targets: Vec<GraspTarget>,
    /// False: the servos report zero torque.
    has_torques: bool,
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
        let mut wiring = SensorSetup::from_robot(robot);
        for (hand, rate_hz) in wiring.hands.iter_mut().zip(scene.sensor_rate_hz) {
            hand.rate_hz = f64::from(rate_hz);
        }
        Self {
            robot: robot.clone(),
            world: Box::new(world),
            controller: Box::new(Controller::new(robot, wiring, settings)),
            sensed: Sensed::default(),
            command: JointCommand::default(),
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
            self.sensed.joints.effort_n_m.fill(0.0);
            self.sensed.joints.seal();
        }
        self.sensed
            .frames
            .iter_mut()
            .flatten()
            .for_each(&mut frame_filter);
        let frames = [
            as_slice(&self.sensed.frames[0]),
            as_slice(&self.sensed.frames[1]),
        ];
        let tick = Tick {
            index: self.index,
            now_ns: self.world.now_ns(),
        };
        let outputs = self.controller.step(&Inputs {
            tick,
            frames,
            joints: Some(&self.sensed.joints),
            targets: &self.targets,
            request,
        });
        self.targets.clear();
        self.command = outputs.command;
        self.world.advance(Some(&self.command));
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
        let ended = |state, reason| GoalUpdate {
            state,
            reason,
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
        let reason = Reason::with_limit(shm_schemas::Cause::TIMED_OUT, limit_s, limit_s);
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

fn as_slice<T>(frame: &Option<T>) -> &[T] {
    frame.as_slice()
}
