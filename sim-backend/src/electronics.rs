//! Sensors, drives and clock of the simulated robot: everything between physics and controller.
//!
//! Both engines use it, so noise, errors, rates, latencies and expiry are the same for both.

use robot_model::{HandSide, RobotModel, RobotVector};
use shm_schemas::{HandFrame, JointCommand, JointSetpoints, JointState, Stamp};

use crate::clock::Clock;
use crate::drive::Drive;
use crate::encoder;
use crate::random::Random;
use crate::scene::{Scene, stream};
use crate::sensed_hand::SensedHand;
use crate::sensor::{HandSensor, SeededModel};
use crate::servo_lag::ServoLag;

#[derive(Clone, Debug)]
pub(crate) struct Electronics {
    sensors: [HandSensor; 2],
    drive: Drive,
    lag: Option<ServoLag>,
    pub(crate) clock: Clock,
    joint_sequence: u64,
}

/// Sensor data of one tick.
#[derive(Clone, Debug, Default)]
pub struct Sensed {
    /// Sealed frames, left and right; `None` in ticks without a new sample.
    pub frames: [Option<HandFrame>; 2],
    /// Joint feedback.
    pub joints: JointState,
}

impl Electronics {
    pub(crate) fn new(robot: &RobotModel, scene: &Scene, start: RobotVector, seed: u64) -> Self {
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
            let model = SeededModel {
                model: &scene.sensor_model,
                seed,
                first_tip: tip,
            };
            HandSensor::new(
                side,
                layout,
                rate_hz,
                scene.noise_factor,
                noise,
                errors,
                model,
            )
        };
        Self {
            sensors: HandSide::BOTH.map(sensor),
            drive: Drive::holding(start, joint_speeds_rad_s(robot)),
            lag: ServoLag::new(scene.errors.servo_lag_s, &start),
            clock: Clock::new(Random::new(seed, stream::EPOCH).bits()),
            joint_sequence: 0,
        }
    }

    /// Samples all sensors due in this tick.
    pub(crate) fn sense<H: SensedHand>(&mut self, hands: &[H; 2], out: &mut Sensed) {
        for ((sensor, hand), frame) in self.sensors.iter_mut().zip(hands).zip(&mut out.frames) {
            sensor.sample(
                &self.clock,
                |finger, force_n| hand.element_forces(finger, force_n),
                frame,
            );
        }
        out.joints = JointState::default();
        out.joints.stamp = self.clock.stamp(self.joint_sequence);
        self.joint_sequence += 1;
        for hand in hands {
            encoder::append_joints(&hand.joints(), hand.model(), &mut out.joints);
        }
        self.drive.report(&mut out.joints);
        out.joints.seal();
    }

    /// Takes the command that arrived during the tick, if any; returns the set-points of the tick.
    pub(crate) fn setpoints(&mut self, command: Option<&JointCommand>) -> JointSetpoints {
        let commanded = self.drive.setpoints(command, self.clock.now_ns);
        match &mut self.lag {
            None => commanded,
            Some(lag) => lag.follow(&commanded),
        }
    }

    /// Returns the number of rejected commands plus expiries without a successor.
    pub(crate) fn expired(&self) -> u32 {
        self.drive.expired()
    }

    /// Returns the stamp of a payload that is written in this tick.
    pub(crate) fn stamp(&self) -> Stamp {
        self.clock.stamp(self.clock.tick)
    }

    /// Returns the sensor of a hand.
    pub(crate) fn sensor(&self, hand: usize) -> Option<&HandSensor> {
        self.sensors.get(hand)
    }
}

fn joint_speeds_rad_s(robot: &RobotModel) -> RobotVector {
    let speed = |joint| robot.joint(joint).map_or(0.0, |it| it.velocity_max);
    RobotVector::from_fn(robot.joint_count(), speed)
}
