//! Simulated world: two hands, their sensors and the objects on the table, tick by tick.

use robot_model::{Capsules, HandSide, HandVector, RobotModel};
use shm_schemas::{JointCommand, JointSetpoints, WorldTruth};

use crate::base_motion::{BaseMotion, BaseMotionError};
use crate::builtin::BuiltIn;
use crate::clock::SUBSTEP_S;
use crate::electronics::{Electronics, Sensed};
use crate::engine::{Engine, EngineError};
use crate::external::External;
use crate::fingertip::Fingertip;
use crate::hand::Hand;
use crate::hand_body::HandBody;
use crate::hold::Grip;
use crate::random::Random;
use crate::range::{OutOfRange, in_range};
use crate::scene::{Scene, SceneError, stream};
use crate::sensed_hand::SensedHand;
use crate::support::{Ground, Plate, Rim};
use crate::thread::CapTruth;
use crate::threaded_cap::ThreadedCap;
use crate::vibration::Vibration;
use crate::world_object::WorldObject;

/// Largest external force on an object per axis, N. Design choice: ten times the holding force of
/// two fingertips.
const PULL_MAX_N: f64 = 100.0;
/// Largest height of a bump, m, and range of its duration, s. Design choice: the displaced
/// fingertips stay within the distance at which the contact search begins.
const BUMP_MAX_M: f64 = 0.01;
const BUMP_S: [f64; 2] = [0.02, 10.0];

/// Failure that ends the simulation: the world freezes from then on.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum WorldFault {
    /// Joint of this hand.
    #[error(
        "simulation stopped: a joint of the {0:?} hand is not finite; report the scene and the seed"
    )]
    Joints(HandSide),
    /// Index of the object.
    #[error("simulation stopped: object {0} is not finite; check that its mass suits its size")]
    Object(usize),
    /// Failure of an external engine.
    #[error(transparent)]
    Engine(#[from] EngineError),
}

/// Simulated robot in front of a table. Deterministic: the same scene, seed and commands give the
/// same bits. With an external engine, this depends on the engine.
#[derive(Debug)]
pub struct World {
    electronics: Electronics,
    physics: Physics,
    objects: Vec<WorldObject>,
    plates: Vec<Plate>,
    base_motion: BaseMotion,
    fault: Option<WorldFault>,
}

/// Engine that moves joints and objects.
#[derive(Debug)]
#[expect(
    clippy::large_enum_variant,
    reason = "a world has one, and worlds are on the heap"
)]
enum Physics {
    BuiltIn(BuiltIn),
    External(External),
}

impl World {
    /// Returns a world at rest: objects standing, hands at the scene's start posture, virtual time
    /// [`crate::START_NS`].
    ///
    /// # Errors
    /// [`SceneError`] if the scene cannot be simulated.
    pub fn new(robot: &RobotModel, scene: &Scene, seed: u64) -> Result<Self, SceneError> {
        Self::build(robot, scene, seed, None)
    }

    /// Returns a world at rest whose physics `engine` computes. Sensors, drives, errors and ground
    /// truth are those of [`World::new`].
    ///
    /// # Errors
    /// [`SceneError`] if the scene cannot be simulated, or the engine cannot build it.
    pub fn with_engine(
        robot: &RobotModel,
        scene: &Scene,
        seed: u64,
        engine: Box<dyn Engine>,
    ) -> Result<Self, SceneError> {
        Self::build(robot, scene, seed, Some(engine))
    }

    fn build(
        robot: &RobotModel,
        scene: &Scene,
        seed: u64,
        engine: Option<Box<dyn Engine>>,
    ) -> Result<Self, SceneError> {
        scene.check()?;
        let start = scene.start(robot)?;
        let vibration = |side: HandSide| {
            let mut random = Random::new(seed, stream::VIBRATION + side.index() as u64);
            Vibration::new(scene.vibration_m, SUBSTEP_S, &mut random)
        };
        let body = |side| HandBody::draw(robot.hand(side), &scene.errors, seed);
        let bodies = [body(HandSide::Left)?, body(HandSide::Right)?];
        let vibrations = HandSide::BOTH.map(vibration);
        let mut objects = WorldObject::from_scene(scene);
        let physics = match engine {
            Some(engine) => Physics::External(External::new(
                engine, robot, bodies, scene, &start, vibrations, seed,
            )?),
            None => {
                let start = |side| HandVector::from_slice(&start[robot.joint_range(side)]);
                let [left, right] = bodies;
                let [of_left, of_right] = vibrations;
                let mut threaded_cap = ThreadedCap::from_scene(&scene.objects);
                if let Some(cap) = &mut threaded_cap {
                    cap.initialise(&mut objects, SUBSTEP_S);
                }
                Physics::BuiltIn(BuiltIn {
                    hands: [
                        Hand::new(left, start(HandSide::Left), of_left),
                        Hand::new(right, start(HandSide::Right), of_right),
                    ],
                    threaded_cap,
                })
            }
        };
        Ok(Self {
            electronics: Electronics::new(robot, scene, start, seed),
            physics,
            objects,
            plates: scene.plates.clone(),
            base_motion: BaseMotion::STILL,
            fault: None,
        })
    }

    /// Returns a copy in the present state, which continues with the same bits; `None` with an
    /// external engine.
    #[must_use]
    pub fn copy(&self) -> Option<Self> {
        let Physics::BuiltIn(built_in) = &self.physics else {
            return None;
        };
        Some(Self {
            electronics: self.electronics.clone(),
            physics: Physics::BuiltIn(built_in.clone()),
            objects: self.objects.clone(),
            plates: self.plates.clone(),
            base_motion: self.base_motion,
            fault: self.fault.clone(),
        })
    }

    /// Samples all sensors due in this tick. Call once per tick, before [`World::advance`].
    pub fn sense(&mut self, out: &mut Sensed) {
        match &self.physics {
            Physics::BuiltIn(built_in) => self.electronics.sense(&built_in.hands, out),
            Physics::External(external) => self.electronics.sense(&external.hands, out),
        }
    }

    /// Simulates one tick. `command` is the command that arrived during the tick, if any. It takes
    /// effect [`LATENCY_MS`](crate::LATENCY_MS) later, until it expires. After a [`World::fault`]
    /// only time advances.
    pub fn advance(&mut self, command: Option<&JointCommand>) {
        let orders = self.electronics.setpoints(command);
        if self.fault.is_none() {
            self.fault = self.simulate(&orders).err();
        }
        self.electronics.clock.advance();
    }

    /// Applies an external force at an object's centre of mass until the next call, base frame, N.
    /// Examples: water poured into a bottle, a person pulling.
    ///
    /// # Errors
    /// [`OutOfRange`] if the object does not exist or the force is not within ±100 N; the world is
    /// unchanged then.
    pub fn pull(&mut self, object: usize, force_n: [f64; 3]) -> Result<(), OutOfRange> {
        for force_n in force_n {
            in_range("a pull in newtons", force_n, -PULL_MAX_N, PULL_MAX_N)?;
        }
        let count = self.objects.len();
        let Some(pulled) = self.objects.get_mut(object) else {
            let last = count.saturating_sub(1) as f64;
            return in_range("the index of a pulled object", object as f64, 0.0, last);
        };
        pulled.body.pull_n = force_n.into();
        Ok(())
    }

    /// Bumps the arm of a hand: its fingertips rise and return in `duration_s`, unnoticed by the
    /// encoders. A negative height bumps downwards. Hand 0 is left.
    ///
    /// # Errors
    /// [`OutOfRange`] if the hand does not exist, the height is not within ±10 mm or the duration
    /// not within 0.02 to 10 s; the world is unchanged then.
    pub fn bump(&mut self, hand: usize, height_m: f64, duration_s: f64) -> Result<(), OutOfRange> {
        let [shortest_s, longest_s] = BUMP_S;
        in_range("a bump in metres", height_m, -BUMP_MAX_M, BUMP_MAX_M)?;
        in_range("a bump in seconds", duration_s, shortest_s, longest_s)?;
        in_range("the index of a bumped hand", hand as f64, 0.0, 1.0)?;
        match &mut self.physics {
            Physics::BuiltIn(it) => it.hands[hand].bump(height_m, duration_s),
            Physics::External(it) => it.hands[hand].bump(height_m, duration_s),
        }
        Ok(())
    }

    /// Restarts slip and turn of an object in the ground truth: from the next tick on, they count
    /// from the present pose in the hand. Ignores an object that does not exist.
    pub fn restart_slip(&mut self, object: usize) {
        if let Some(object) = self.objects.get_mut(object) {
            object.restart_hold();
        }
    }

    /// Sets the motion of the robot's base until the next call. Objects that the robot does not
    /// hold move relative to the base; held objects receive its inertial forces.
    ///
    /// # Errors
    /// [`BaseMotionError`] if a value is not finite or beyond the limits of a base, or the base
    /// moves in a world of an external engine; the world is unchanged then.
    pub fn set_base_motion(&mut self, ride: &BaseMotion) -> Result<(), BaseMotionError> {
        ride.check()?;
        if ride.is_moving() && matches!(self.physics, Physics::External(_)) {
            return Err(BaseMotionError::ExternalEngine);
        }
        self.base_motion = *ride;
        Ok(())
    }

    /// Returns the ground truth for evaluation.
    #[must_use]
    pub fn truth(&self) -> WorldTruth {
        let mut truth = WorldTruth {
            stamp: self.electronics.stamp(),
            object_count: self.objects.len() as u32,
            expired_commands: self.electronics.expired(),
            ..WorldTruth::default()
        };
        for (index, (slot, object)) in truth.objects.iter_mut().zip(&self.objects).enumerate() {
            *slot = object.truth(self.physics.cap_truth(index));
        }
        self.physics.each_contact(|hand, finger, normal_n, slip_m| {
            truth.normal_n[hand][finger] = normal_n;
            truth.slip_m[hand][finger] = slip_m;
        });
        truth
    }

    /// Returns the true collision capsules of a hand and its arm, base frame; none for a missing
    /// hand. Hand 0 is left.
    #[must_use]
    pub fn bodies(&self, hand: usize) -> Capsules {
        let bodies = match &self.physics {
            Physics::BuiltIn(it) => it.hands.get(hand).map(Hand::bodies),
            Physics::External(it) => it.hands.get(hand).map(|hand| hand.bodies()),
        };
        bodies.unwrap_or(Capsules::new())
    }

    /// Returns the share of a fingertip's normal force on sliding bristles, 0 to 1; 1 is gross
    /// slip. Hand 0 is left. An external engine has no bristles: always 0.
    #[must_use]
    pub fn sliding_share(&self, hand: usize, finger: usize) -> f64 {
        let hand = self.built_in_hand(hand);
        let contact = hand.and_then(|hand| hand.contacts.get(finger));
        contact.map_or(0.0, |contact| contact.sliding_share)
    }

    /// Returns a copy of a fingertip for bench tests, with its skin and electronics; `None` if it
    /// does not exist or an external engine simulates it. Hand 0 is left.
    #[must_use]
    pub fn fingertip(&self, hand: usize, finger: usize) -> Option<Fingertip> {
        let (sensor, hand) = (self.electronics.sensor(hand)?, self.built_in_hand(hand)?);
        let radius_m = *hand.model().tip_radius_m().get(finger)?;
        let (tip, layout) = (sensor.tip(finger)?, hand.model().skin().layout);
        Some(Fingertip::new(&hand.pads()[finger], radius_m, tip, layout))
    }

    /// Returns the current time, ns.
    #[must_use]
    pub fn now_ns(&self) -> u64 {
        self.electronics.clock.now_ns
    }

    /// Returns the number of simulated ticks.
    #[must_use]
    pub fn tick(&self) -> u64 {
        self.electronics.clock.tick
    }

    /// Returns the fault that stopped the simulation, if any.
    #[must_use]
    pub fn fault(&self) -> Option<WorldFault> {
        self.fault.clone()
    }

    /// Sets the clock forward without simulating, so that a late process skips the missed ticks.
    /// Ignores times in the past.
    pub fn skip_to(&mut self, now_ns: u64) {
        self.electronics.clock.now_ns = self.electronics.clock.now_ns.max(now_ns);
    }

    /// Replaces the seed's writer epoch, so that readers can distinguish a process from its
    /// predecessor.
    pub fn set_writer_epoch(&mut self, writer_epoch: u64) {
        self.electronics.clock.writer_epoch = writer_epoch;
    }

    fn built_in_hand(&self, hand: usize) -> Option<&Hand> {
        match &self.physics {
            Physics::BuiltIn(built_in) => built_in.hands.get(hand),
            Physics::External(_) => None,
        }
    }

    fn simulate(&mut self, orders: &JointSetpoints) -> Result<(), WorldFault> {
        let objects = &mut self.objects;
        match &mut self.physics {
            Physics::BuiltIn(it) => {
                it.simulate(orders, objects, &self.plates, &mut self.base_motion);
            }
            Physics::External(it) => it.simulate(orders, objects)?,
        }
        self.evaluate_objects();
        self.check_finite()
    }

    fn evaluate_objects(&mut self) {
        let closed = self.physics.is_closed();
        for index in 0..self.objects.len() {
            let carried = self.physics.constrains(index);
            let ground = Ground {
                plates: &self.plates,
                rim: self.physics.rim_for(index, &self.objects),
                ride: self.base_motion,
            };
            let grip = self.physics.grip_on(index);
            let object = &mut self.objects[index];
            let open = object.has_neck() && !closed;
            object.evaluate(&ground, carried, open, self.electronics.clock.now_ns);
            object.update_hold(grip.as_ref(), carried);
        }
    }

    fn check_finite(&self) -> Result<(), WorldFault> {
        let is_wild = |side: &HandSide| {
            let hand = self.built_in_hand(side.index());
            hand.is_some_and(|hand| !hand.plant.is_finite())
        };
        if let Some(side) = HandSide::BOTH.into_iter().find(is_wild) {
            return Err(WorldFault::Joints(side));
        }
        let mut objects = self.objects.iter();
        match objects.position(|object| !object.body.is_finite()) {
            Some(index) => Err(WorldFault::Object(index)),
            None => Ok(()),
        }
    }
}

impl Physics {
    /// Calls `visit` with hand, fingertip, normal force, N, and slip, m, of each fingertip.
    fn each_contact(&self, mut visit: impl FnMut(usize, usize, f64, f64)) {
        for hand in 0..2 {
            match self {
                Self::BuiltIn(it) => {
                    for (finger, tip) in it.hands[hand].contacts.iter().enumerate() {
                        visit(hand, finger, tip.normal_n, tip.slip_m);
                    }
                }
                Self::External(it) => {
                    for (finger, tip) in it.hands[hand].tips().iter().enumerate() {
                        visit(hand, finger, tip.normal_n, tip.slip_m);
                    }
                }
            }
        }
    }

    fn grip_on(&self, object: usize) -> Option<Grip> {
        match self {
            Self::BuiltIn(it) => it.hands.iter().find_map(|hand| hand.grip_on(object)),
            Self::External(it) => it.hands.iter().find_map(|hand| hand.grip_on(object)),
        }
    }

    fn cap_truth(&self, object: usize) -> Option<CapTruth> {
        match self {
            Self::BuiltIn(it) => it.threaded_cap.as_ref()?.truth(object),
            Self::External(it) => it.cap_truth(object),
        }
    }

    /// Returns true if the thread determines the motion of this object.
    fn constrains(&self, object: usize) -> bool {
        match self {
            Self::BuiltIn(it) => it
                .threaded_cap
                .as_ref()
                .is_some_and(|it| it.constrains(object)),
            Self::External(it) => it.constrains(object),
        }
    }

    fn is_closed(&self) -> bool {
        match self {
            Self::BuiltIn(it) => it.threaded_cap.as_ref().is_some_and(ThreadedCap::is_closed),
            Self::External(it) => it.is_closed(),
        }
    }

    /// Returns the rim under a loose cap. For an external engine, the rim is part of its support.
    fn rim_for(&self, object: usize, objects: &[WorldObject]) -> Option<Rim> {
        match self {
            Self::BuiltIn(it) => it.threaded_cap.as_ref()?.rim_for(object, objects),
            Self::External(_) => None,
        }
    }
}
