//! The tick rate is the user's choice: with sensors and joints at 1 kHz, tasks come out the same from 100 Hz to 10 kHz.

use atas_core::check;
use atas_core::{Controller, Inputs, Order, Settings, Tick, Wiring};
use atas_evaluation::offline::{grasp_goal, pick_place_goal};
use robot_model::{RobotModel, Side};
use shm_schemas::{GoalRequest, GoalState, GoalUpdate, HandFrame, JointCommand, JointState, Mode};
use sim_backend::{Object, Scene, Sensed, TICK_NS, World};

/// Steps in which the hand moves with an object.
const CARRYING: [&str; 3] = ["lift", "convey", "place"];
/// Longest task of these tests, ms.
const LONGEST_MS: u32 = 90_000;
/// How much faster than at 1 kHz a joint may be while it carries. Ours: what one more push of Module 2 makes.
const MARGIN: f64 = 2.0;

/// Shortest life of a command that the daemon's configuration allows, periods of the tick.
const VALID_PERIODS: f64 = 1.5;

/// A controller that ticks at its own rate in front of a world that samples every millisecond.
struct Fast<'a> {
    robot: &'a RobotModel,
    world: World,
    controller: Box<Controller>,
    rate_hz: u64,
    index: u64,
    command: JointCommand,
    /// What waits for the next tick.
    frames: [Vec<HandFrame>; 2],
    order: Option<Order>,
    /// Highest speed that was commanded of any joint while an object was carried, rad/s.
    carrying_rad_s: f64,
}

impl<'a> Fast<'a> {
    fn new(robot: &'a RobotModel, scene: &Scene, rate_hz: u64) -> Self {
        let wiring = Wiring {
            tick_s: 1.0 / rate_hz as f64,
            ..Wiring::default()
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
            order: None,
            carrying_rad_s: 0.0,
        }
    }

    /// One millisecond with the ticks that are due in it, if any. The first takes in what the sensors sent since the tick
    /// before, the others go on with what is known.
    fn millisecond(&mut self, order: Option<Order>) -> Option<GoalUpdate> {
        let mut sensed = Sensed::default();
        self.world.sense(&mut sensed);
        for (waiting, frame) in self.frames.iter_mut().zip(&sensed.frames) {
            waiting.extend(frame);
        }
        self.order = order.or(self.order.take());
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
            order: self.order.take().as_ref(),
        });
        self.index += 1;
        self.command = outputs.command;
        if carries {
            let speeds = &outputs.command.velocity_rad_s[..outputs.command.joint_count as usize];
            let fastest_rad_s = speeds.iter().map(|v| v.abs()).fold(0.0, f64::max);
            self.carrying_rad_s = self.carrying_rad_s.max(fastest_rad_s);
        }
        outputs.goal_update
    }

    fn pursue(&mut self, request: &GoalRequest) -> GoalUpdate {
        while self.controller.mode().0 != Mode::READY {
            self.millisecond(None);
        }
        // What is said before the robot is known is no command.
        let refused = self.world.truth().expired_commands;
        let now = self.controller.circumstances(self.robot, &[]);
        let goal = check::check(request, &now).expect("reachable");
        let mut order = Some(Order::Start(goal));
        for _ in 0..LONGEST_MS {
            let update = self.millisecond(order.take());
            if let Some(end) = update.filter(|update| update.state.is_final()) {
                let expired = self.world.truth().expired_commands - refused;
                assert_eq!(expired, 0, "commands expired at {} Hz", self.rate_hz);
                return end;
            }
        }
        panic!("no end at {} Hz", self.rate_hz);
    }
}

/// Pursues a goal at every rate. It must succeed, and the joints must not swing: they carry the object no faster than at
/// 1 kHz, but for a margin.
fn check(what: &str, scene: &Scene, request: &GoalRequest) {
    let robot = RobotModel::two_hand_arm().expect("built in");
    let mut calm_rad_s = f64::INFINITY;
    for rate_hz in [1000, 100, 250, 500, 2000, 4000, 10_000] {
        let mut fast = Fast::new(&robot, scene, rate_hz);
        let end = fast.pursue(request);
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
fn grasps_hold_at_every_rate() {
    for name in ["slippery-50", "sponge"] {
        let scene = Scene::grasp(Object::built_in(name).expect("built in"), Side::Right);
        let hint = scene.grasp_hint(0).expect("an object");
        check(name, &scene, &grasp_goal(&hint, Side::Right, 0.04, 1.0));
    }
}

#[test]
fn placing_holds_at_every_rate() {
    let scene = Scene::pick_place(Object::built_in("wood").expect("built in"), Side::Right);
    let hint = scene.grasp_hint(0).expect("an object");
    let place = scene.place.expect("a place");
    let goal = pick_place_goal(&hint, Side::Right, &place, 0.04);
    check("wood", &scene, &goal);
}
