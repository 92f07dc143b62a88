//! Tests of the configurable tick rate: with sensors and joints at 1 kHz, tasks succeed from 100 Hz
//! to 10 kHz.

use atas_core::check;
use atas_core::{Controller, Inputs, OperatorRequest, SensorSetup, Settings, Tick};
use atas_evaluation::goals::{grasp_goal, pick_place_goal};
use robot_model::{HandSide, RobotModel};
use shm_schemas::{GoalRequest, GoalState, GoalUpdate, HandFrame, JointCommand, JointState, Mode};
use sim_backend::{Object, Scene, Sensed, TICK_NS, World};

/// Steps in which the hand moves an object.
const CARRYING: [&str; 3] = ["lift", "convey", "place"];
/// Timeout of a task, ms.
const TASK_TIMEOUT_MS: u32 = 90_000;
/// Largest ratio of the joint speed while carrying to that at 1 kHz. Derived from one additional
/// correction of Module 2 (slip).
const MARGIN: f64 = 2.0;

/// Shortest command validity that the daemon's configuration allows, tick periods.
const VALID_PERIODS: f64 = 1.5;

/// A controller at its own tick rate with a world that samples every millisecond.
struct RateRun<'a> {
    robot: &'a RobotModel,
    world: World,
    controller: Box<Controller>,
    rate_hz: u64,
    index: u64,
    command: JointCommand,
    /// Frames received since the last tick.
    frames: [Vec<HandFrame>; 2],
    request: Option<OperatorRequest>,
    /// Highest commanded speed of any joint while carrying, rad/s.
    carrying_rad_s: f64,
}

impl<'a> RateRun<'a> {
    fn new(robot: &'a RobotModel, scene: &Scene, rate_hz: u64) -> Self {
        let wiring = SensorSetup {
            tick_s: 1.0 / rate_hz as f64,
            ..SensorSetup::default()
        };
        let mut settings = Settings::default();
        settings.safety.valid_s = settings.safety.valid_s.max(VALID_PERIODS / rate_hz as f64);
        Self {
            robot,
            world: World::new(robot, scene, 7).expect("a world"),
            controller: Box::new(Controller::new(robot, wiring, settings)),
            rate_hz,
            index: 0,
            command: JointCommand::default(),
            frames: Default::default(),
            request: None,
            carrying_rad_s: 0.0,
        }
    }

    /// Runs one millisecond with the ticks due in it. The first tick receives the sensor data since
    /// the last tick; the others receive none.
    fn millisecond(&mut self, order: Option<OperatorRequest>) -> Option<GoalUpdate> {
        let mut sensed = Sensed::default();
        self.world.sense(&mut sensed);
        for (waiting, frame) in self.frames.iter_mut().zip(&sensed.frames) {
            waiting.extend(frame);
        }
        self.request = order.or(self.request.take());
        let (ticks, mut news) = (self.ticks_due(), None);
        for part in 0..ticks {
            let now_ns = self.world.now_ns() + part * TICK_NS / ticks;
            let update = self.tick(now_ns, (part == 0).then_some(&sensed.joints));
            news = update.or(news);
        }
        let command = (ticks > 0).then_some(&self.command);
        self.world.advance(command);
        news
    }

    fn ticks_due(&self) -> u64 {
        if self.rate_hz >= 1000 {
            return self.rate_hz / 1000;
        }
        u64::from(self.world.tick().is_multiple_of(1000 / self.rate_hz))
    }

    fn tick(&mut self, now_ns: u64, joints: Option<&JointState>) -> Option<GoalUpdate> {
        let carries = CARRYING.contains(&self.controller.step_name());
        let frames = std::mem::take(&mut self.frames);
        let outputs = self.controller.step(&Inputs {
            tick: Tick {
                index: self.index,
                now_ns,
            },
            frames: [&frames[0], &frames[1]],
            joints,
            targets: &[],
            request: self.request.take().as_ref(),
        });
        self.index += 1;
        self.command = outputs.command;
        if carries {
            let speeds = &outputs.command.velocity[..outputs.command.joint_count as usize];
            let fastest_rad_s = speeds.iter().map(|v| v.abs()).fold(0.0, f64::max);
            self.carrying_rad_s = self.carrying_rad_s.max(fastest_rad_s);
        }
        outputs.goal_update
    }

    fn run_goal(&mut self, request: &GoalRequest) -> GoalUpdate {
        while self.controller.mode().0 != Mode::READY {
            self.millisecond(None);
        }
        // Commands before the controller knows the robot's state are not valid and do not count.
        let refused = self.world.truth().expired_commands;
        let now = self.controller.goal_context(self.robot, &[]);
        let goal = check::check(request, &now).expect("reachable");
        let mut order = Some(OperatorRequest::Start(goal));
        for _ in 0..TASK_TIMEOUT_MS {
            let update = self.millisecond(order.take());
            if let Some(end) = update.filter(|update| update.state.is_final()) {
                let expired = self.world.truth().expired_commands - refused;
                assert_eq!(expired, 0, "commands expired at {} Hz", self.rate_hz);
                return end;
            }
        }
        panic!("goal did not end in time at {} Hz", self.rate_hz);
    }
}

/// Runs a goal at every rate. It must succeed, and the joints must not oscillate: while carrying,
/// their speed stays below `MARGIN` times that at 1 kHz.
fn check(what: &str, scene: &Scene, request: &GoalRequest) {
    let robot = RobotModel::two_hand_arm().expect("built in");
    let mut calm_rad_s = f64::INFINITY;
    for rate_hz in [1000, 100, 250, 500, 2000, 4000, 10_000] {
        let mut fast = RateRun::new(&robot, scene, rate_hz);
        let end = fast.run_goal(request);
        assert_eq!(
            end.state,
            GoalState::SUCCEEDED,
            "{what} at {rate_hz} Hz: {}",
            end.reason
        );
        let swing_rad_s = fast.carrying_rad_s;
        assert!(
            swing_rad_s < MARGIN * calm_rad_s,
            "{what} at {rate_hz} Hz: {swing_rad_s} rad/s, at 1 kHz {calm_rad_s}"
        );
        if rate_hz == 1000 {
            calm_rad_s = swing_rad_s;
        }
    }
}

#[test]
fn grasps_succeed_at_every_rate() {
    for name in ["slippery-50", "sponge"] {
        let scene = Scene::grasp(Object::built_in(name).expect("built in"), HandSide::Right);
        let hint = scene.grasp_hint(0).expect("an object");
        check(name, &scene, &grasp_goal(&hint, HandSide::Right, 0.04, 1.0));
    }
}

#[test]
fn placing_succeeds_at_every_rate() {
    let scene = Scene::pick_place(Object::built_in("wood").expect("built in"), HandSide::Right);
    let hint = scene.grasp_hint(0).expect("an object");
    let place = scene.place.expect("a place");
    let goal = pick_place_goal(&hint, HandSide::Right, &place, 0.04);
    check("wood", &scene, &goal);
}
