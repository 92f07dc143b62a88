//! Test bench for the gate, and a checker of its output.

use crate::support::JOINTS;
use crate::support::{MS_NS, hand_of, home_rad, robot};
use atas_core::Tick;
use atas_core::kinematics::HandCommand;
use atas_core::limits::{JOINT_ACCELERATION_RAD_S2, JOINT_JERK_RAD_S3};
use atas_core::safety::{Gate, GateContext, Grip, SafeCommand};
use atas_core::settings::{Safety, Settings};
use proptest::prelude::*;
use robot_model::{HandSide, Joint, RobotVector};
use shm_schemas::Mode;

pub(crate) type Joints = RobotVector;

/// Hand without grip force.
pub(crate) const NO_GRIP: Grip = Grip {
    normal_n: [0.0; 2],
    f2_n: None,
};

/// Gate with its clock.
pub(crate) struct GateBench {
    pub(crate) gate: Gate,
    pub(crate) settings: Safety,
    pub(crate) step_s: f64,
    pub(crate) index: u64,
    pub(crate) grips: [Grip; 2],
    pub(crate) closing_m_s: [[f64; 2]; 2],
    pub(crate) measured_rad: Option<Joints>,
}

impl GateBench {
    pub(crate) fn new() -> Self {
        let mut gate = Gate::new(robot(), 77);
        gate.synchronise(&home_rad());
        Self {
            gate,
            settings: Settings::default().safety,
            step_s: 1e-3,
            index: 0,
            grips: [NO_GRIP; 2],
            closing_m_s: [[0.0; 2]; 2],
            measured_rad: None,
        }
    }

    /// Ticks per millisecond, at least one.
    pub(crate) fn ticks_per_ms(&self) -> usize {
        ((1e-3 / self.step_s) as usize).max(1)
    }

    pub(crate) fn pass(&mut self, mode: Mode, wanted_rad: &Joints) -> SafeCommand {
        let raw = HandSide::BOTH.map(|side| {
            HandCommand::new(hand_of(wanted_rad, side), self.closing_m_s[side.index()])
        });
        let tick = Tick {
            index: self.index,
            now_ns: 1_000 * MS_NS + (self.index as f64 * self.step_s * 1e9) as u64,
        };
        self.index += 1;
        self.gate.pass(
            &raw,
            &self.grips,
            &GateContext {
                tick,
                step_s: self.step_s,
                mode,
                measured_rad: self.measured_rad.as_ref(),
                joint_sequence: 5,
                grip_limit_n: [0.0; 2],
                settings: &self.settings,
            },
        )
    }
}

pub(crate) fn positions(safe: &SafeCommand) -> Joints {
    RobotVector::from_slice(&safe.command().position_rad[..JOINTS])
}

pub(crate) fn velocities(safe: &SafeCommand) -> Joints {
    RobotVector::from_slice(&safe.command().velocity_rad_s[..JOINTS])
}

/// Checks published positions against every limit of every joint.
pub(crate) struct LimitChecker {
    position_rad: Joints,
    velocity_rad_s: Joints,
    acceleration_rad_s2: Joints,
    step_s: f64,
}

impl LimitChecker {
    pub(crate) fn new(rig: &GateBench) -> Self {
        Self {
            position_rad: *rig.gate.position_rad(),
            velocity_rad_s: RobotVector::repeat(JOINTS, 0.0),
            acceleration_rad_s2: RobotVector::repeat(JOINTS, 0.0),
            step_s: rig.step_s,
        }
    }

    pub(crate) fn check(&mut self, safe: &SafeCommand) -> Result<(), TestCaseError> {
        prop_assert!(safe.command().is_intact());
        prop_assert!(
            safe.command()
                .position_rad
                .iter()
                .chain(&safe.command().velocity_rad_s)
                .all(|v| v.is_finite())
        );
        for (i, joint) in robot().joints().enumerate() {
            self.check_joint(i, joint, positions(safe)[i], velocities(safe)[i])?;
        }
        Ok(())
    }

    fn check_joint(
        &mut self,
        i: usize,
        joint: &Joint,
        position_rad: f64,
        told_rad_s: f64,
    ) -> Result<(), TestCaseError> {
        let velocity_rad_s = (position_rad - self.position_rad[i]) / self.step_s;
        let acceleration_rad_s2 = (velocity_rad_s - self.velocity_rad_s[i]) / self.step_s;
        let jerk_rad_s3 = (acceleration_rad_s2 - self.acceleration_rad_s2[i]) / self.step_s;
        let bounded = |value: f64, limit: f64| value.abs() <= limit * (1.0 + 1e-6) + 1e-6;
        prop_assert!(
            position_rad >= joint.lower_rad && position_rad <= joint.upper_rad,
            "{}: {position_rad} rad",
            joint.name
        );
        prop_assert!(
            (told_rad_s - velocity_rad_s).abs() < 1e-9,
            "{}: reported {told_rad_s}, actual {velocity_rad_s} rad/s",
            joint.name
        );
        prop_assert!(
            bounded(velocity_rad_s, joint.velocity_max_rad_s),
            "{}: {velocity_rad_s} rad/s",
            joint.name
        );
        prop_assert!(
            bounded(acceleration_rad_s2, JOINT_ACCELERATION_RAD_S2),
            "{}: {acceleration_rad_s2} rad/s²",
            joint.name
        );
        prop_assert!(
            bounded(jerk_rad_s3, JOINT_JERK_RAD_S3),
            "{}: {jerk_rad_s3} rad/s³",
            joint.name
        );
        self.position_rad[i] = position_rad;
        self.velocity_rad_s[i] = velocity_rad_s;
        self.acceleration_rad_s2[i] = acceleration_rad_s2;
        Ok(())
    }
}
