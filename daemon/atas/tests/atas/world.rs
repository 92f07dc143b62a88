//! Minimal simulation for the whole controller: ideal joints, two sensors, optionally one elastic
//! object.

use crate::support::{JOINTS, MS_NS, frame, hand_of, home, joints, press, robot, spread};
use atas_core::{Controller, Goal, Inputs, OperatorRequest, Outputs, SensorSetup, Settings, Tick};
use nalgebra::Vector3;
use robot_model::{GRASP_SIDES, HandSide, RobotVector};
use shm_schemas::{
    GoalKind, GoalPolicy, GoalRequest, GoalState, GraspTarget, Hand, HandFrame, JointState, Mode,
};
use std::sync::LazyLock;

/// Object position and width, m.
pub(crate) const OBJECT_M: [f64; 3] = [0.3, -0.1, 0.06];
pub(crate) const WIDTH_M: f64 = 0.05;
/// Object stiffness, N/m, load, N, and friction coefficient.
const OBJECT_N_M: f64 = 8000.0;
const LOAD_N: f64 = 1.0;
const FRICTION: f64 = 0.8;
/// Largest horizontal offset of the hand from the object for contact, m; the object has no height.
const CONTACT_OFFSET_MAX_M: f64 = 0.005;
const OBSTACLE_N: f64 = 0.5;
/// Increase of the load while lifting, N/m.
const LOADING_N_M: f64 = 400.0;

#[derive(Clone)]
pub(crate) struct World {
    /// Boxed because worlds are moved and copied on the small stacks of test threads.
    pub(crate) controller: Box<Controller>,
    pub(crate) ms: u64,
    pub(crate) q: RobotVector,
    /// Silent sources: left sensor, right sensor, joints.
    pub(crate) silent: [bool; 3],
    /// F_2 per hand that the robot stores and reports, N.
    pub(crate) stored_f2_n: [f64; 2],
    /// Corruption of every joint state.
    pub(crate) joint_fault: Option<fn(&mut JointState)>,
    /// Corruption of every frame of the right hand.
    pub(crate) frame_fault: Option<fn(&mut HandFrame)>,
    pub(crate) has_object: bool,
    /// Object position, m.
    pub(crate) object_m: [f64; 3],
    /// True if an obstacle presses on the second fingertip of the right hand.
    pub(crate) obstructed: bool,
    pub(crate) targets: Vec<GraspTarget>,
    /// Recorded inputs, if recording.
    pub(crate) log: Option<Vec<Logged>>,
}

#[derive(Clone)]
pub(crate) struct Logged {
    tick: Tick,
    pub(crate) frames: [Vec<HandFrame>; 2],
    joints: Option<JointState>,
    targets: Vec<GraspTarget>,
    request: Option<OperatorRequest>,
}

impl Logged {
    pub(crate) fn inputs(&self) -> Inputs<'_> {
        Inputs {
            tick: self.tick,
            frames: [&self.frames[0], &self.frames[1]],
            joints: self.joints.as_ref(),
            targets: &self.targets,
            request: self.request.as_ref(),
        }
    }
}

impl World {
    /// World at home before the first tick.
    pub(crate) fn new() -> Self {
        Self {
            controller: Box::new(Controller::new(
                robot(),
                SensorSetup::default(),
                Settings::default(),
            )),
            ms: 1_000,
            q: home(),
            silent: [false; 3],
            stored_f2_n: [0.0; 2],
            joint_fault: None,
            frame_fault: None,
            has_object: false,
            object_m: OBJECT_M,
            obstructed: false,
            targets: Vec::new(),
            log: None,
        }
    }

    pub(crate) fn ready() -> Self {
        static READY: LazyLock<World> = LazyLock::new(|| {
            let mut world = World::new();
            world.run(50);
            assert_eq!(world.mode(), Mode::READY);
            world
        });
        READY.clone()
    }

    /// World in which the right hand approaches the object, in step `reach`.
    pub(crate) fn reaching() -> Self {
        let mut world = Self::ready();
        world.request(start(grasp()));
        world.run(300);
        assert_eq!(
            (world.mode(), world.controller.step_name()),
            (Mode::RUN, "reach")
        );
        world
    }

    /// World in which the right hand has lifted and holds the object; the goal has succeeded.
    pub(crate) fn holding() -> Self {
        static HOLDING: LazyLock<World> = LazyLock::new(|| {
            let mut world = World::ready();
            world.has_object = true;
            world.request(start(grasp()));
            let (outputs, _) = world.run_until(60_000, |world| {
                world.controller.goal().unwrap().state.is_final()
            });
            let update = outputs.goal_update.unwrap();
            assert_eq!(
                update.state,
                GoalState::SUCCEEDED,
                "{}: {:?}",
                update.reason,
                update.figures
            );
            world
        });
        HOLDING.clone()
    }

    /// Replaces the controller by a new one in the present state, like a daemon restart.
    pub(crate) fn restart(&mut self) {
        self.controller = World::new().controller;
        self.run_until(100, |w| w.mode() == Mode::RUN);
        self.run(1);
    }

    pub(crate) fn mode(&self) -> Mode {
        self.controller.mode().0
    }

    pub(crate) fn tick(&mut self) -> Outputs {
        self.tick_with(None)
    }

    pub(crate) fn request(&mut self, order: OperatorRequest) -> Outputs {
        self.tick_with(Some(&order))
    }

    /// Runs some ticks; returns the last outputs.
    pub(crate) fn run(&mut self, ticks: usize) -> Outputs {
        (0..ticks).map(|_| self.tick()).last().unwrap()
    }

    /// Runs until a condition holds; returns the last outputs and the number of ticks.
    pub(crate) fn run_until(
        &mut self,
        at_most: usize,
        holds: impl Fn(&World) -> bool,
    ) -> (Outputs, usize) {
        for ticks in 1..=at_most {
            let outputs = self.tick();
            if holds(self) {
                return (outputs, ticks);
            }
        }
        panic!(
            "condition not reached: mode {}, step {}",
            self.mode(),
            self.controller.step_name()
        );
    }

    fn tick_with(&mut self, order: Option<&OperatorRequest>) -> Outputs {
        self.ms += 1;
        let now_ns = self.ms * MS_NS;
        let mut frames = [
            self.tactile_frame(HandSide::Left, now_ns),
            self.tactile_frame(HandSide::Right, now_ns),
        ];
        if let Some(fault) = self.frame_fault {
            fault(&mut frames[1]);
            frames[1].seal();
        }
        let mut state = joints(self.ms, now_ns, &self.q);
        state.grip_limit_n = self.stored_f2_n;
        if let Some(fault) = self.joint_fault {
            fault(&mut state);
        }
        state.seal();
        let [left, right] = frames;
        let muted = |frame: HandFrame, i: usize| if self.silent[i] { vec![] } else { vec![frame] };
        let received = Logged {
            tick: Tick {
                index: self.ms,
                now_ns,
            },
            frames: [muted(left, 0), muted(right, 1)],
            joints: (!self.silent[2]).then_some(state),
            targets: core::mem::take(&mut self.targets),
            request: order.copied(),
        };
        let outputs = *self.controller.step(&received.inputs());
        if let Some(log) = &mut self.log {
            log.push(received);
        }
        if outputs.command.joint_count > 0 {
            self.q.copy_from_slice(&outputs.command.position[..JOINTS]);
            self.stored_f2_n = outputs.command.grip_limit_n;
        }
        outputs
    }

    /// Frame of one hand in contact with the object, if any.
    fn tactile_frame(&self, side: HandSide, now_ns: u64) -> HandFrame {
        let mut frame = frame(Hand::BOTH[side.index()], self.ms, now_ns);
        if side == HandSide::Right && self.obstructed {
            press(&mut frame, 1, |d| {
                Vector3::z() * -OBSTACLE_N * spread(Vector3::z(), 33.0)(d)
            });
        }
        if side == HandSide::Left || !self.has_object {
            return frame;
        }
        let hand = robot().hand(side);
        let pose = hand.forward(&hand_of(&self.q, side));
        let centre_m = (pose.tip_m(0) + pose.tip_m(1)) / 2.0;
        let away_m = (centre_m - Vector3::from(self.object_m)).xy().norm();
        let across = (pose.tip_m(0) - pose.tip_m(1)).normalize();
        for finger in 0..GRASP_SIDES {
            let out = if finger == 0 { across } else { -across };
            let reach_m = (pose.tip_m(finger) - Vector3::from(self.object_m)).dot(&out)
                - hand.tip_radius_m()[finger];
            let pressed_m = WIDTH_M / 2.0 - reach_m;
            if pressed_m <= 0.0 || away_m > CONTACT_OFFSET_MAX_M {
                continue;
            }
            let tip = hand.skin().compression;
            let bends_m = |f: f64| tip.at_1n_m * f.powf(tip.exponent) + f / OBJECT_N_M;
            let normal_n = solve(bends_m, pressed_m, 50.0);
            let wanted_n = (LOADING_N_M * (centre_m.z - self.object_m[2])).clamp(0.0, LOAD_N / 2.0);
            let base_from_tip = pose.base_from_tip()[finger].rotation;
            let down = base_from_tip.transpose() * -Vector3::z();
            press(&mut frame, finger, sheared(normal_n, wanted_n, down));
        }
        frame
    }
}

/// Round contact at the pole under load with stick and slip: all elements shift equally until they
/// slip.
fn sheared(
    normal_n: f64,
    load_n: f64,
    down: Vector3<f64>,
) -> impl Fn(Vector3<f64>) -> Vector3<f64> {
    let share = spread(Vector3::z(), 33.0);
    let layout = &crate::support::dome().0;
    let shares: Vec<f64> = layout.normal[..layout.count]
        .iter()
        .map(|d| share(Vector3::from(*d)))
        .collect();
    let carried_n = |slide_n: f64| {
        shares
            .iter()
            .map(|s| (FRICTION * normal_n * s).min(slide_n))
            .sum::<f64>()
    };
    let slide_n = solve(carried_n, load_n, normal_n);
    let along = Vector3::new(down.x, down.y, 0.0).normalize();
    move |d| {
        let pressed_n = normal_n * share(d);
        along * (FRICTION * pressed_n).min(slide_n) - Vector3::z() * pressed_n
    }
}

/// Inverts an increasing function by bisection between 0 and `high`.
fn solve(rising: impl Fn(f64) -> f64, value: f64, mut high: f64) -> f64 {
    let mut low = 0.0;
    for _ in 0..30 {
        let middle = (low + high) / 2.0;
        if rising(middle) < value {
            low = middle
        } else {
            high = middle
        }
    }
    high
}

/// Goal: the right hand grasps the object.
pub(crate) fn grasp() -> GoalRequest {
    GoalRequest {
        goal_id: 7,
        kind: GoalKind::GRASP,
        hand: Hand::RIGHT,
        policy: GoalPolicy::DETACHED,
        from_m: OBJECT_M,
        width_m: WIDTH_M,
        lift_m: 0.03,
        hold_s: 0.2,
        ..GoalRequest::default()
    }
}

pub(crate) fn start(request: GoalRequest) -> OperatorRequest {
    OperatorRequest::Start(Goal::resolve(&request, &[]).unwrap())
}

/// Commanded distance between the fingertips of the right hand, m.
pub(crate) fn commanded_gap_m(outputs: &Outputs) -> f64 {
    let q = RobotVector::from_slice(&outputs.command.position[..JOINTS]);
    atas_core::kinematics::gap_m(
        &robot()
            .hand(HandSide::Right)
            .forward(&hand_of(&q, HandSide::Right)),
    )
}
