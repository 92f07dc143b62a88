//! Simulated world: two hands, their sensors and the objects on the table, tick by tick.

use robot_model::{Capsules, HandSide, HandVector, RobotModel, RobotVector};
use shm_schemas::capacity::JOINTS;
use shm_schemas::{HandFrame, JointCommand, JointSetpoints, JointState, WorldTruth};

use crate::base_motion::BaseMotion;
use crate::clock::Clock;
use crate::drive::Drive;
use crate::encoder;
use crate::fingertip::Fingertip;
use crate::hand::Hand;
use crate::random::Random;
use crate::range::{OutOfRange, in_range};
use crate::scene::{Scene, SceneError, stream};
use crate::sensor::HandSensor;
use crate::support::{Ground, Plate};
use crate::threaded_cap::ThreadedCap;
use crate::vibration::Vibration;
use crate::world_object::WorldObject;

/// Length of a tick, s: [`crate::TICK_NS`].
const TICK_S: f64 = 1e-3;
/// Substeps per tick. 500 µs is unstable for light objects, 125 µs gives the same results (tactile
/// design).
const SUBSTEPS: usize = 4;
const SUBSTEP_S: f64 = TICK_S / SUBSTEPS as f64;
/// Largest external force on an object per axis, N. Design choice: ten times the holding force of
/// two fingertips.
const PULL_MAX_N: f64 = 100.0;

/// Sensor data of one tick.
#[derive(Clone, Debug, Default)]
pub struct Sensed {
    /// Sealed frames, left and right; `None` in ticks without a new sample.
    pub frames: [Option<HandFrame>; 2],
    /// Joint feedback.
    pub joints: JointState,
}

/// Non-finite state that ends the simulation: the world freezes from then on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum WorldFault {
    /// Joint of this hand.
    #[error(
        "simulation stopped: a joint of the {0:?} hand is not finite; report the scene and the seed"
    )]
    Joints(HandSide),
    /// Index of the object.
    #[error("simulation stopped: object {0} is not finite; check that its mass suits its size")]
    Object(usize),
}

/// Simulated robot in front of a table. Deterministic: the same scene, seed and commands give the
/// same bits.
#[derive(Clone, Debug)]
pub struct World {
    hands: [Hand; 2],
    sensors: [HandSensor; 2],
    objects: Vec<WorldObject>,
    plates: Vec<Plate>,
    threaded_cap: Option<ThreadedCap>,
    base_motion: BaseMotion,
    drive: Drive,
    clock: Clock,
    joint_sequence: u64,
    fault: Option<WorldFault>,
}

fn joint_speeds_rad_s(robot: &RobotModel) -> RobotVector {
    let speed = |joint| robot.joint(joint).map_or(0.0, |it| it.velocity_max_rad_s);
    RobotVector::from_fn(robot.joint_count(), speed)
}

impl World {
    /// Returns a world at rest: objects standing, hands at the scene's start posture, virtual time
    /// [`crate::START_NS`].
    ///
    /// # Errors
    /// [`SceneError`] if the scene cannot be simulated.
    pub fn new(robot: &RobotModel, scene: &Scene, seed: u64) -> Result<Self, SceneError> {
        scene.check()?;
        let start_rad = scene.start(robot)?;
        let hand = |side: HandSide| {
            let start = HandVector::from_slice(&start_rad[robot.joint_range(side)]);
            let mut random = Random::new(seed, stream::VIBRATION + side.index() as u64);
            let vibration = Vibration::new(scene.vibration_m, SUBSTEP_S, &mut random);
            Hand::new(robot.hand(side), start, vibration, &scene.errors, seed)
        };
        let sensor = |side: HandSide| {
            let fingers = robot.hand(side).fingertip_count() as u64;
            let random = |first| {
                (first..first + fingers)
                    .map(|tip| Random::new(seed, tip))
                    .collect()
            };
            let rate_hz = scene.sensor_rate_hz[side.index()];
            let before = HandSide::BOTH[..side.index()].iter();
            let tip: u64 = before
                .map(|side| robot.hand(*side).fingertip_count() as u64)
                .sum();
            let errors = (&scene.errors, random(stream::TIP_ERRORS + tip));
            let noise = random(stream::TIP_SENSOR + tip);
            let layout = robot.hand(side).skin().layout.layout();
            HandSensor::new(side, layout, rate_hz, scene.noise_factor, noise, errors)
        };
        let mut objects = WorldObject::from_scene(scene);
        let mut closure = ThreadedCap::from_scene(&scene.objects);
        if let Some(closure) = &mut closure {
            closure.initialise(&mut objects, SUBSTEP_S);
        }
        Ok(Self {
            hands: [hand(HandSide::Left)?, hand(HandSide::Right)?],
            sensors: HandSide::BOTH.map(sensor),
            objects,
            plates: scene.plates.clone(),
            threaded_cap: closure,
            base_motion: BaseMotion::STILL,
            drive: Drive::holding(start_rad, joint_speeds_rad_s(robot)),
            clock: Clock::new(Random::new(seed, stream::EPOCH).bits()),
            joint_sequence: 0,
            fault: None,
        })
    }

    /// Samples all sensors due in this tick. Call once per tick, before [`World::advance`].
    pub fn sense(&mut self, out: &mut Sensed) {
        let Self {
            hands,
            sensors,
            clock,
            ..
        } = self;
        for ((sensor, hand), frame) in sensors.iter_mut().zip(hands).zip(&mut out.frames) {
            sensor.sample(clock, hand.pads(), &hand.contacts, frame);
        }
        out.joints = JointState::default();
        out.joints.stamp = self.clock.stamp(self.joint_sequence);
        self.joint_sequence += 1;
        for hand in &self.hands {
            encoder::append_joints(&hand.plant, hand.model(), &mut out.joints);
        }
        self.drive.report(&mut out.joints);
        out.joints.seal();
    }

    /// Simulates one tick. `command` is the command that arrived during the tick, if any. It takes
    /// effect [`LATENCY_MS`](crate::LATENCY_MS) later, until it expires. After a [`World::fault`]
    /// only time advances.
    pub fn advance(&mut self, command: Option<&JointCommand>) {
        let orders = self.drive.setpoints(command, self.clock.now_ns);
        if self.fault.is_none() {
            self.simulate(&orders);
            self.fault = self.find_fault();
        }
        self.clock.advance();
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

    /// Sets the motion of the robot's base until the next call. Objects that the robot does not
    /// hold move relative to the base; held objects receive its inertial forces.
    ///
    /// # Errors
    /// [`OutOfRange`] if a value is not finite or beyond the limits of a base; the world is
    /// unchanged then.
    pub fn set_base_motion(&mut self, ride: &BaseMotion) -> Result<(), OutOfRange> {
        ride.check()?;
        self.base_motion = *ride;
        Ok(())
    }

    /// Returns the ground truth for evaluation.
    #[must_use]
    pub fn truth(&self) -> WorldTruth {
        let mut truth = WorldTruth {
            stamp: self.clock.stamp(self.clock.tick),
            object_count: self.objects.len() as u32,
            expired_commands: self.drive.expired(),
            ..WorldTruth::default()
        };
        for (index, (slot, object)) in truth.objects.iter_mut().zip(&self.objects).enumerate() {
            let cap = self
                .threaded_cap
                .as_ref()
                .and_then(|closure| closure.truth(index));
            *slot = object.truth(cap);
        }
        for (hand, simulated) in self.hands.iter().enumerate() {
            for (finger, contact) in simulated.contacts.iter().enumerate() {
                truth.slip_m[hand][finger] = contact.slip_m;
                truth.normal_n[hand][finger] = contact.normal_n;
            }
        }
        truth
    }

    /// Returns the true collision capsules of a hand and its arm, base frame; none for a missing
    /// hand. Hand 0 is left.
    #[must_use]
    pub fn bodies(&self, hand: usize) -> Capsules {
        let hand = self.hands.get(hand);
        hand.map_or(Capsules::new(), Hand::bodies)
    }

    /// Returns the share of a fingertip's normal force on sliding bristles, 0 to 1; 1 is gross
    /// slip. Hand 0 is left.
    #[must_use]
    pub fn sliding_share(&self, hand: usize, finger: usize) -> f64 {
        let hand = self.hands.get(hand);
        let contact = hand.and_then(|hand| hand.contacts.get(finger));
        contact.map_or(0.0, |contact| contact.sliding_share)
    }

    /// Returns a copy of a fingertip for bench tests, with its skin and electronics; `None` if it
    /// does not exist. Hand 0 is left.
    #[must_use]
    pub fn fingertip(&self, hand: usize, finger: usize) -> Option<Fingertip> {
        let (sensor, hand) = (self.sensors.get(hand)?, self.hands.get(hand)?);
        let radius_m = *hand.model().tip_radius_m().get(finger)?;
        let (tip, layout) = (sensor.tip(finger)?, hand.model().skin().layout);
        Some(Fingertip::new(&hand.pads()[finger], radius_m, tip, layout))
    }

    /// Returns the current time, ns.
    #[must_use]
    pub fn now_ns(&self) -> u64 {
        self.clock.now_ns
    }

    /// Returns the number of simulated ticks.
    #[must_use]
    pub fn tick(&self) -> u64 {
        self.clock.tick
    }

    /// Returns the fault that stopped the simulation, if any.
    #[must_use]
    pub fn fault(&self) -> Option<WorldFault> {
        self.fault
    }

    /// Sets the clock forward without simulating, so that a late process skips the missed ticks.
    /// Ignores times in the past.
    pub fn skip_to(&mut self, now_ns: u64) {
        self.clock.now_ns = self.clock.now_ns.max(now_ns);
    }

    /// Replaces the seed's writer epoch, so that readers can distinguish a process from its
    /// predecessor.
    pub fn set_writer_epoch(&mut self, writer_epoch: u64) {
        self.clock.writer_epoch = writer_epoch;
    }

    fn simulate(&mut self, orders: &JointSetpoints) {
        let [left, right] = self
            .hands
            .each_ref()
            .map(|hand| hand.model().joints().len());
        let per_hand = |values: &[f64; JOINTS]| {
            [0..left, left..left + right].map(|range| HandVector::from_slice(&values[range]))
        };
        let (target_rad, feed_forward_rad_s) = (
            per_hand(&orders.position_rad),
            per_hand(&orders.velocity_rad_s),
        );
        for hand in &mut self.hands {
            hand.begin_tick(&self.objects, TICK_S);
        }
        for substep in 0..SUBSTEPS {
            for hand in &mut self.hands {
                hand.compute_contacts(&mut self.objects, SUBSTEP_S);
            }
            for (index, hand) in self.hands.iter_mut().enumerate() {
                hand.step(
                    &target_rad[index],
                    &feed_forward_rad_s[index],
                    SUBSTEPS - substep,
                    SUBSTEP_S,
                );
            }
            self.move_objects();
        }
        self.evaluate_objects();
    }

    /// Simulates one substep of threaded cap, objects and base motion.
    fn move_objects(&mut self) {
        if let Some(closure) = &mut self.threaded_cap {
            closure.apply_load(&mut self.objects, SUBSTEP_S);
        }
        for index in 0..self.objects.len() {
            let closure = self.threaded_cap.as_ref();
            if closure.is_some_and(|closure| closure.constrains(index)) {
                continue;
            }
            let rim = closure.and_then(|closure| closure.rim_for(index, &self.objects));
            let (plates, ride) = (&self.plates, self.base_motion);
            self.objects[index].step(&Ground { plates, rim, ride }, SUBSTEP_S);
        }
        self.base_motion.integrate(SUBSTEP_S);
        if let Some(closure) = &mut self.threaded_cap {
            closure.update(&mut self.objects, SUBSTEP_S);
        }
    }

    fn evaluate_objects(&mut self) {
        let closure = self.threaded_cap.as_ref();
        let closed = closure.is_some_and(ThreadedCap::is_closed);
        for index in 0..self.objects.len() {
            let carried = closure.is_some_and(|closure| closure.constrains(index));
            let rim = closure.and_then(|closure| closure.rim_for(index, &self.objects));
            let ground = Ground {
                plates: &self.plates,
                rim,
                ride: self.base_motion,
            };
            let object = &mut self.objects[index];
            let open = object.has_neck() && !closed;
            object.evaluate(&ground, carried, open, self.clock.now_ns);
            let grip = self.hands.iter().find_map(|hand| hand.grip_on(index));
            object.update_hold(grip.as_ref(), carried);
        }
    }

    fn find_fault(&self) -> Option<WorldFault> {
        let joints = HandSide::BOTH
            .into_iter()
            .find(|side| !self.hands[side.index()].plant.is_finite());
        let object = || {
            self.objects
                .iter()
                .position(|object| !object.body.is_finite())
        };
        joints
            .map(WorldFault::Joints)
            .or_else(|| object().map(WorldFault::Object))
    }
}
