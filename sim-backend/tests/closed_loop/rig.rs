//! Test rig: controller and world, tick by tick.

use std::ops::RangeInclusive;

use atas_core::{
    Controller, Goal, Inputs, OperatorRequest, Outputs, SensorSetup, Settings, Tick, check,
};
use robot_model::{HandSide, HandVector, RobotModel, clearance_m, farthest_move_m};
use shm_schemas::capacity::JOINTS;
use shm_schemas::{
    Cause, EventKind, GoalKind, GoalPolicy, GoalRequest, GoalState, GoalUpdate, Hand, HandFrame,
    Mode, ModuleEvent, ObjectTruth, Reason,
};
use sim_backend::{GraspHint, Object, Scene, Sensed, World};

pub(crate) struct Rig {
    pub(crate) world: World,
    controller: Box<Controller>,
    robot: RobotModel,
    sensed: Sensed,
    tick: u64,
    epoch: u64,
    pub(crate) warnings: Vec<Cause>,
    /// Total commanded path of all joints, rad.
    pub(crate) travelled_rad: f64,
    commanded_position: Option<[f64; JOINTS]>,
    pub(crate) regrasp_count: usize,
    pub(crate) end: Option<GoalUpdate>,
    corruption: Option<Corruption>,
    missing: Missing,
    /// The servos report no torque.
    pub(crate) is_torque_missing: bool,
}

/// Inputs that currently do not arrive.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Missing {
    pub(crate) frames: [bool; 2],
    pub(crate) joints: bool,
}

/// Sensor corruption: hand, start time and function.
struct Corruption {
    side: HandSide,
    since_ns: u64,
    of: Box<CorruptFrame>,
}

/// Change of a frame; the number is the time since the corruption began, s.
type CorruptFrame = dyn Fn(f64, &mut HandFrame);

fn controller(robot: &RobotModel, writer_epoch: u64) -> Box<Controller> {
    let wiring = SensorSetup {
        writer_epoch,
        ..SensorSetup::from_robot(robot)
    };
    Box::new(Controller::new(robot, wiring, Settings::default()))
}

pub(crate) fn object(name: &str) -> Object {
    Object::built_in(name).expect("built-in object")
}

/// Displaces an object from its nominal pose: mm, mm, degrees.
pub(crate) fn displace(scene: &mut Scene, index: usize, [x_mm, y_mm, yaw_deg]: [f64; 3]) {
    let placed = &mut scene.objects[index];
    placed.position_m[0] += x_mm * 1e-3;
    placed.position_m[1] += y_mm * 1e-3;
    placed.yaw_rad += f64::to_radians(yaw_deg);
}

impl Rig {
    /// Returns the two-hand arm at rest, the controller READY.
    pub(crate) fn new(scene: &Scene) -> Self {
        Self::seeded(scene, 1)
    }

    /// Same, with another seed for errors and noise.
    pub(crate) fn seeded(scene: &Scene, seed: u64) -> Self {
        let robot = RobotModel::two_hand_arm().expect("the built-in robot loads");
        Self::with_robot(robot, scene, seed)
    }

    /// Returns a rig with another robot.
    pub(crate) fn with_robot(robot: RobotModel, scene: &Scene, seed: u64) -> Self {
        let mut rig = Self {
            world: World::new(&robot, scene, seed).expect("valid scene"),
            controller: controller(&robot, 1),
            robot,
            sensed: Sensed::default(),
            tick: 0,
            epoch: 1,
            warnings: Vec::new(),
            travelled_rad: 0.0,
            commanded_position: None,
            regrasp_count: 0,
            end: None,
            corruption: None,
            missing: Missing::default(),
            is_torque_missing: false,
        };
        rig.ticks(100);
        assert_eq!(rig.controller.mode().0, Mode::READY);
        rig
    }

    /// Corrupts the frames of a hand from now on.
    pub(crate) fn corrupt_skin(
        &mut self,
        side: HandSide,
        of: impl Fn(f64, &mut HandFrame) + 'static,
    ) {
        let (since_ns, of) = (self.world.now_ns(), Box::new(of));
        self.corruption = Some(Corruption { side, since_ns, of });
    }

    fn step(&mut self, order: Option<&OperatorRequest>) -> &Outputs {
        self.world.sense(&mut self.sensed);
        if let Some(lie) = &self.corruption {
            let lied_s = (self.world.now_ns() - lie.since_ns) as f64 * 1e-9;
            for frame in self.sensed.frames[lie.side.index()].iter_mut() {
                (lie.of)(lied_s, frame);
                frame.seal();
            }
        }
        if self.is_torque_missing {
            self.sensed.joints.effort = [0.0; JOINTS];
            self.sensed.joints.seal();
        }
        let [left, right] = &self.sensed.frames;
        let outputs = self.controller.step(&Inputs {
            tick: Tick {
                index: self.tick,
                now_ns: self.world.now_ns(),
            },
            frames: [
                arrived(left.as_slice(), self.missing.frames[0]),
                arrived(right.as_slice(), self.missing.frames[1]),
            ],
            joints: (!self.missing.joints).then_some(&self.sensed.joints),
            targets: &[],
            request: order,
        });
        self.world.advance(Some(&outputs.command));
        self.tick += 1;
        let now_rad = outputs.command.position;
        let before_rad = self.commanded_position.replace(now_rad).unwrap_or(now_rad);
        let steps_rad = now_rad
            .iter()
            .zip(before_rad)
            .map(|(now, before)| (now - before).abs());
        self.travelled_rad += steps_rad.sum::<f64>();
        self.end = outputs
            .goal_update
            .filter(|update| update.state.is_final())
            .or(self.end);
        let warns = |kind: EventKind| kind == EventKind::WARNING;
        let events = outputs.events.as_slice().iter();
        let comes_again =
            |e: &&ModuleEvent| e.kind == EventKind::STEP && e.text.as_str() == "regrasp";
        self.regrasp_count += events.clone().filter(comes_again).count();
        self.warnings
            .extend(events.filter(|e| warns(e.kind)).map(|e| e.reason.cause));
        outputs
    }

    pub(crate) fn ticks(&mut self, count: u64) {
        for _ in 0..count {
            self.step(None);
        }
    }

    /// Runs `ms` ticks without these inputs.
    pub(crate) fn drop_inputs(&mut self, missing: Missing, ms: u64) {
        self.missing = missing;
        self.ticks(ms);
        self.missing = Missing::default();
    }

    /// Simulates the world without controller ticks.
    pub(crate) fn stall(&mut self, alone_ms: u64) {
        for _ in 0..alone_ms {
            self.world.sense(&mut self.sensed);
            self.world.advance(None);
        }
        self.tick += alone_ms;
    }

    /// Simulates the world without a daemon, then starts a new one.
    pub(crate) fn restart(&mut self, alone_ms: u64) {
        self.stall(alone_ms);
        self.epoch += 1;
        self.controller = controller(&self.robot, self.epoch);
        self.tick = 0;
    }

    pub(crate) fn send_request(&mut self, order: &OperatorRequest) {
        self.step(Some(order));
    }

    /// Starts a goal and runs as [`Rig::run_until`].
    pub(crate) fn execute_until(&mut self, request: &GoalRequest, step: &str, lifted_m: f64) {
        self.begin(request);
        self.run_until(step, lifted_m);
    }

    /// Validates a goal as the daemon does.
    fn validated_goal(&self, request: &GoalRequest) -> Goal {
        self.check(request).expect("valid goal")
    }

    /// Returns the reason why a goal is rejected.
    pub(crate) fn rejection_reason(&self, request: &GoalRequest) -> Reason {
        self.check(request).expect_err("rejected goal")
    }

    fn check(&self, request: &GoalRequest) -> Result<Goal, Reason> {
        let circumstances = self.controller.goal_context(&self.robot, &[]);
        check::check(request, &circumstances)
    }

    pub(crate) fn begin(&mut self, request: &GoalRequest) {
        let goal = self.validated_goal(request);
        self.send_request(&OperatorRequest::Start(goal));
    }

    /// Runs until this step of the goal's hand, with the first object lifted this high.
    pub(crate) fn run_until(&mut self, step: &str, lifted_m: f64) {
        for _ in 0..100_000 {
            if self.step_name() == step && self.object().lifted_m >= lifted_m {
                return;
            }
            self.ticks(1);
        }
        panic!("step {step} not reached, now in {}", self.step_name());
    }

    pub(crate) fn step_name(&self) -> &str {
        self.controller.step_name()
    }

    pub(crate) fn mode(&self) -> Mode {
        self.controller.mode().0
    }

    pub(crate) fn reason(&self) -> Reason {
        self.controller.mode().1
    }

    pub(crate) fn execute(&mut self, request: &GoalRequest) -> GoalUpdate {
        let goal = self.validated_goal(request);
        let mut order = Some(OperatorRequest::Start(goal));
        for _ in 0..400_000 {
            let update = self.step(order.take().as_ref()).goal_update;
            if let Some(end) = update.filter(|update| update.state.is_final()) {
                return end;
            }
        }
        panic!("the goal does not end");
    }

    /// Executes a goal that must succeed.
    pub(crate) fn execute_successfully(&mut self, request: &GoalRequest) {
        let end = self.execute(request);
        assert_eq!(
            end.state,
            GoalState::SUCCEEDED,
            "{}: {}",
            end.step,
            end.reason
        );
    }

    /// Increases the first object's load to `to_n`, N.
    pub(crate) fn load(&mut self, to_n: f64, n_per_s: f64) {
        let ticks = (to_n / n_per_s * 1e3).ceil() as u64;
        for tick in 1..=ticks {
            let pull_n = to_n * tick as f64 / ticks as f64;
            self.world
                .pull(0, [0.0, 0.0, -pull_n])
                .expect("valid force");
            self.ticks(1);
        }
    }

    /// Returns the largest deviation of each arm's bodies from their commanded position, m.
    pub(crate) fn deviations_m(&self) -> [f64; 2] {
        let q = self.commanded_position.expect("commands have been sent");
        HandSide::BOTH.map(|side| {
            let (hand, joints) = (self.robot.hand(side), self.robot.joint_range(side));
            let pose = hand.forward(&HandVector::from_slice(&q[joints]));
            farthest_move_m(&hand.capsules(&pose), &self.world.bodies(side.index()))
        })
    }

    pub(crate) fn gap_m(&self) -> f64 {
        clearance_m(&self.world.bodies(0), &self.world.bodies(1))
    }

    /// Returns the mean true normal force per side of the right hand with two fingertips, N.
    pub(crate) fn grip_n(&self) -> f64 {
        self.world.truth().normal_n[1].iter().sum::<f64>() / 2.0
    }

    pub(crate) fn object(&self) -> ObjectTruth {
        self.world.truth().objects[0]
    }
}

/// Returns a client's goal for the first object.
pub(crate) fn goal(kind: GoalKind, scene: &Scene, side: HandSide) -> GoalRequest {
    let GraspHint {
        from_m,
        yaw_rad,
        width_m,
        ..
    } = scene.grasp_hint(0).expect("scene has an object");
    GoalRequest {
        goal_id: 1,
        kind,
        hand: Hand::BOTH[side.index()],
        policy: GoalPolicy::DETACHED,
        from_m,
        from_yaw_rad: yaw_rad,
        width_m,
        lift_m: if kind == GoalKind::SCREW { 0.0 } else { 0.05 },
        hold_s: 1.0,
        to_m: scene.place.map_or(from_m, |place| place.from_m),
        to_yaw_rad: scene.place.map_or(yaw_rad, |place| place.yaw_rad),
        helper_width_m: scene.grasp_hint(1).map_or(0.0, |hint| hint.width_m),
        ..GoalRequest::default()
    }
}

fn arrived(frames: &[HandFrame], is_missing: bool) -> &[HandFrame] {
    if is_missing { &[] } else { frames }
}

/// Returns the seeds 1 to `affordable`, or to the environment variable `ATAS_SEEDS`.
pub(crate) fn seeds(affordable: u64) -> RangeInclusive<u64> {
    let asked = std::env::var("ATAS_SEEDS").ok();
    1..=asked.map_or(affordable, |count| {
        count.parse().expect("ATAS_SEEDS is a number of seeds")
    })
}
