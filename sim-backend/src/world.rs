//! The world: two hands, their sensors, the objects on the table, one millisecond at a time.

use core::array;

use nalgebra::Vector3;
use robot_model::{FINGERS, HAND_JOINTS, HandVector, ROBOT_JOINTS, RobotModel, Side};
use shm_schemas::{HandFrame, JointCommand, JointState, Layout, Stamp, WorldTruth};

use crate::drive::{Drive, Orders};
use crate::hand::Hand;
use crate::pad::{DOME_ELEMENTS, Pad};
use crate::random::Random;
use crate::scene::{Scene, SceneError, stream};
use crate::sensor::{TipSensor, encoder_rad, measured_effort_n_m, measured_velocity_rad_s};
use crate::thing::Thing;
use crate::vibration::Vibration;

/// Length of a tick, ns and s.
pub const TICK_NS: u64 = 1_000_000;
const TICK_S: f64 = 1e-3;
/// Substeps per tick. 500 µs is unstable for light objects, 125 µs gives the same results (tactile design).
const SUBSTEPS: usize = 4;
const SUBSTEP_S: f64 = TICK_S / SUBSTEPS as f64;
/// Virtual time of a new world, ns: one second, so that ages and windows that look back never pass below zero.
pub const START_NS: u64 = 1_000_000_000;

/// What the robot senses at one instant.
#[derive(Clone, Debug, Default)]
pub struct Sensed {
    /// Sealed frames, left and right; `None` when a slow sensor has no new sample.
    pub frames: [Option<HandFrame>; 2],
    /// Joint feedback.
    pub joints: JointState,
}

/// What can no longer be simulated: a number left the finite ones. The world stands still from then on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum WorldFault {
    /// A hand's joints.
    #[error(
        "could not go on because a joint of the {0:?} hand is no longer finite; report the scene and the seed"
    )]
    Joints(Side),
    /// An object, by its index.
    #[error(
        "could not go on because object {0} is no longer finite; is it far lighter than its size suggests?"
    )]
    Object(usize),
}

/// A simulated robot before a table. Deterministic: the same scene, seed and commands give the same bits.
#[derive(Clone, Debug)]
pub struct World {
    hands: [Hand; 2],
    sensors: [HandSensor; 2],
    things: Vec<Thing>,
    drive: Drive,
    pad: Pad,
    layout: Layout,
    layout_hash: u64,
    writer_epoch: u64,
    now_ns: u64,
    tick: u64,
    joint_sequence: u64,
    fault: Option<WorldFault>,
}

/// One hand's sensor.
#[derive(Clone, Debug)]
struct HandSensor {
    tips: [TipSensor; FINGERS],
    rate_hz: u64,
    sequence: u64,
}

impl World {
    /// A world at rest: objects standing, hands where the scene starts them, virtual time [`START_NS`].
    ///
    /// # Errors
    /// [`SceneError`] if the scene cannot be simulated.
    pub fn new(robot: &RobotModel, scene: &Scene, seed: u64) -> Result<Self, SceneError> {
        scene.check()?;
        let start_rad = scene.start(robot)?;
        let layout = Layout::dome_41();
        let hand = |side: Side| {
            let start = HandVector::from_column_slice(&start_rad[side.joint_range()]);
            let mut random = Random::new(seed, stream::VIBRATION + side.index() as u64);
            Hand::new(
                robot.hand(side),
                start,
                Vibration::new(scene.vibration_m, SUBSTEP_S, &mut random),
            )
        };
        Ok(Self {
            hands: Side::BOTH.map(hand),
            sensors: Side::BOTH.map(|side| HandSensor::new(scene, seed, side)),
            things: scene.objects.iter().map(Thing::new).collect(),
            drive: Drive::holding(start_rad),
            pad: Pad::dome_41(),
            layout_hash: layout.hash(),
            layout,
            writer_epoch: Random::new(seed, stream::EPOCH).bits(),
            now_ns: START_NS,
            tick: 0,
            joint_sequence: 0,
            fault: None,
        })
    }

    /// Samples everything that is due now. Call once per tick, before [`World::advance`].
    pub fn sense(&mut self, out: &mut Sensed) {
        for side in Side::BOTH {
            self.sense_hand(side, &mut out.frames[side.index()]);
        }
        self.sense_joints(&mut out.joints);
    }

    /// Simulates one millisecond. `command` is what arrived in it, if anything; it is obeyed from
    /// [`LATENCY_MS`](crate::LATENCY_MS) later until it expires. After a [`World::fault`] only time goes on.
    pub fn advance(&mut self, command: Option<&JointCommand>) {
        let orders = self.drive.orders(command, self.now_ns);
        if self.fault.is_none() {
            self.simulate(&orders);
            self.fault = self.find_fault();
        }
        self.now_ns += TICK_NS;
        self.tick += 1;
    }

    /// The judge's view.
    #[must_use]
    pub fn truth(&self) -> WorldTruth {
        let mut truth = WorldTruth {
            stamp: Stamp {
                sequence: self.tick,
                captured_ns: self.now_ns,
                writer_epoch: self.writer_epoch,
            },
            object_count: self.things.len() as u32,
            expired_commands: self.drive.lapsed(),
            ..WorldTruth::default()
        };
        for (slot, thing) in truth.objects.iter_mut().zip(&self.things) {
            *slot = thing.truth();
        }
        for (hand, simulated) in self.hands.iter().enumerate() {
            for (finger, contact) in simulated.contacts.iter().enumerate() {
                truth.slip_m[hand][finger] = contact.slip_m;
                truth.normal_n[hand][finger] = contact.normal_n;
            }
        }
        truth
    }

    /// Time of the present instant, ns.
    #[must_use]
    pub fn now_ns(&self) -> u64 {
        self.now_ns
    }

    /// Ticks simulated so far.
    #[must_use]
    pub fn tick(&self) -> u64 {
        self.tick
    }

    /// Why the world stands still, if it does.
    #[must_use]
    pub fn fault(&self) -> Option<WorldFault> {
        self.fault
    }

    /// Sets the clock forward to a time of the host's clock without simulating: a process that was late skips the ticks it
    /// missed. A time that has passed changes nothing, because time never goes back.
    pub fn skip_to(&mut self, now_ns: u64) {
        self.now_ns = self.now_ns.max(now_ns);
    }

    /// Replaces the writer epoch that follows from the seed, for a process that must be told from its predecessor.
    pub fn set_writer_epoch(&mut self, writer_epoch: u64) {
        self.writer_epoch = writer_epoch;
    }

    fn simulate(&mut self, orders: &Orders) {
        let per_hand = |values: &[f64; ROBOT_JOINTS]| {
            Side::BOTH.map(|side| HandVector::from_column_slice(&values[side.joint_range()]))
        };
        let (target_rad, feed_forward_rad_s) = (
            per_hand(&orders.position_rad),
            per_hand(&orders.velocity_rad_s),
        );
        for hand in &mut self.hands {
            hand.begin(&self.things, TICK_S);
        }
        for substep in 0..SUBSTEPS {
            for hand in &mut self.hands {
                hand.touch(&self.pad, &mut self.things, SUBSTEP_S);
            }
            for (index, hand) in self.hands.iter_mut().enumerate() {
                hand.step(
                    &target_rad[index],
                    &feed_forward_rad_s[index],
                    SUBSTEPS - substep,
                    SUBSTEP_S,
                );
            }
            for thing in &mut self.things {
                thing.body.step(SUBSTEP_S);
            }
        }
        self.things.iter_mut().for_each(Thing::judge);
    }

    fn find_fault(&self) -> Option<WorldFault> {
        let joints = Side::BOTH
            .into_iter()
            .find(|side| !self.hands[side.index()].plant.is_finite());
        let object = || self.things.iter().position(|thing| !thing.body.is_finite());
        joints
            .map(WorldFault::Joints)
            .or_else(|| object().map(WorldFault::Object))
    }

    fn sense_hand(&mut self, side: Side, out: &mut Option<HandFrame>) {
        let sensor = &mut self.sensors[side.index()];
        if !sensor.is_due(self.tick) {
            *out = None;
            return;
        }
        let frame = out.insert(HandFrame::default());
        frame.stamp = Stamp {
            sequence: sensor.sequence,
            captured_ns: self.now_ns,
            writer_epoch: self.writer_epoch,
        };
        sensor.sequence += 1;
        frame.layout_hash = self.layout_hash;
        frame.hand = shm_schemas::Hand::BOTH[side.index()];
        frame.finger_count = FINGERS as u32;
        let mut force_n = [Vector3::zeros(); DOME_ELEMENTS];
        for finger in 0..FINGERS {
            frame.valid_mask[finger] = (1 << DOME_ELEMENTS) - 1;
            self.hands[side.index()].contacts[finger].element_forces(&self.pad, &mut force_n);
            sensor.tips[finger].sample(&self.layout, &force_n, &mut frame.force_n[finger]);
        }
        frame.seal();
    }

    fn sense_joints(&mut self, out: &mut JointState) {
        *out = JointState::default();
        out.stamp = Stamp {
            sequence: self.joint_sequence,
            captured_ns: self.now_ns,
            writer_epoch: self.writer_epoch,
        };
        self.joint_sequence += 1;
        out.joint_count = ROBOT_JOINTS as u32;
        for side in Side::BOTH {
            let plant = &self.hands[side.index()].plant;
            for joint in 0..HAND_JOINTS {
                let index = side.first_joint() + joint;
                out.position_rad[index] = encoder_rad(joint, plant.position_rad[joint]);
                out.velocity_rad_s[index] = measured_velocity_rad_s(plant.velocity_rad_s[joint]);
                out.effort_n_m[index] = measured_effort_n_m(plant.effort_n_m[joint]);
            }
        }
    }
}

impl HandSensor {
    fn new(scene: &Scene, seed: u64, side: Side) -> Self {
        let index = side.index() as u64;
        let tip = |finger: usize| {
            let random = Random::new(seed, stream::TIP_SENSOR + 4 * index + finger as u64);
            TipSensor::new(scene.noise_factor, random)
        };
        Self {
            tips: array::from_fn(tip),
            rate_hz: scene.sensor_rate_hz[side.index()].into(),
            sequence: 0,
        }
    }

    /// Whether a sample falls into this tick: the sample count rises.
    fn is_due(&self, tick: u64) -> bool {
        let samples = |ticks: u64| ticks * self.rate_hz / 1000;
        tick == 0 || samples(tick) != samples(tick - 1)
    }
}
