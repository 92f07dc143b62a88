//! Test bench for the gate, and a checker of its output.

use crate::support::JOINTS;
use crate::support::{MS_NS, home_of, robot};
use atas_core::Tick;
use atas_core::kinematics::HandCommand;
use atas_core::limits::{JOINT_ACCELERATION_RAD_S2, JOINT_JERK_RAD_S3};
use atas_core::safety::{Gate, GateContext, Grip, SafeCommand};
use atas_core::settings::{Safety, Settings};
use proptest::prelude::*;
use robot_model::{HandSide, HandVector, Joint, PerSide, RobotModel, RobotVector};
use shm_schemas::Mode;

pub(crate) type Joints = RobotVector;

/// Hand without grip force.
pub(crate) const NO_GRIP: Grip = Grip {
    normal_n: PerSide::repeat(0.0),
    f2_n: None,
};

/// Gate with its clock.
pub(crate) struct GateBench {
    robot: &'static RobotModel,
    pub(crate) gate: Gate,
    pub(crate) settings: Safety,
    pub(crate) step_s: f64,
    pub(crate) index: u64,
    pub(crate) grips: [Grip; 2],
    pub(crate) closing_m_s: [[f64; 2]; 2],
    pub(crate) measured: Option<Joints>,
}

impl GateBench {
    pub(crate) fn new() -> Self {
        Self::of(robot())
    }

    pub(crate) fn of(robot: &'static RobotModel) -> Self {
        let mut gate = Gate::new(robot, 77);
        gate.synchronise(&home_of(robot));
        Self {
            robot,
            gate,
            settings: Settings::default().safety,
            step_s: 1e-3,
            index: 0,
            grips: [NO_GRIP; 2],
            closing_m_s: [[0.0; 2]; 2],
            measured: None,
        }
    }

    /// Ticks per millisecond, at least one.
    pub(crate) fn ticks_per_ms(&self) -> usize {
        ((1e-3 / self.step_s) as usize).max(1)
    }

    pub(crate) fn pass(&mut self, mode: Mode, wanted: &Joints) -> SafeCommand {
        let raw = HandSide::BOTH.map(|side| {
            let hand = HandVector::from_slice(&wanted[self.robot.joint_range(side)]);
            HandCommand::new(hand, self.closing_m_s[side.index()].into())
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
                measured: self.measured.as_ref(),
                joint_sequence: 5,
                grip_limit_n: [0.0; 2],
                settings: &self.settings,
            },
        )
    }
}

pub(crate) fn positions(safe: &SafeCommand) -> Joints {
    RobotVector::from_slice(&safe.command().position[..JOINTS])
}

pub(crate) fn velocities(safe: &SafeCommand) -> Joints {
    RobotVector::from_slice(&safe.command().velocity[..JOINTS])
}

/// Checks published positions against every limit of every joint.
pub(crate) struct LimitChecker {
    position: Joints,
    velocity: Joints,
    acceleration_rad_s2: Joints,
    step_s: f64,
}

impl LimitChecker {
    pub(crate) fn new(rig: &GateBench) -> Self {
        Self {
            position: *rig.gate.position(),
            velocity: RobotVector::repeat(JOINTS, 0.0),
            acceleration_rad_s2: RobotVector::repeat(JOINTS, 0.0),
            step_s: rig.step_s,
        }
    }

    pub(crate) fn check(&mut self, safe: &SafeCommand) -> Result<(), TestCaseError> {
        prop_assert!(safe.command().is_intact());
        prop_assert!(
            safe.command()
                .position
                .iter()
                .chain(&safe.command().velocity)
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
        position: f64,
        told_rad_s: f64,
    ) -> Result<(), TestCaseError> {
        let velocity = (position - self.position[i]) / self.step_s;
        let acceleration_rad_s2 = (velocity - self.velocity[i]) / self.step_s;
        let jerk_rad_s3 = (acceleration_rad_s2 - self.acceleration_rad_s2[i]) / self.step_s;
        let bounded = |value: f64, limit: f64| value.abs() <= limit * (1.0 + 1e-6) + 1e-6;
        prop_assert!(
            position >= joint.lower && position <= joint.upper,
            "{}: {position} rad",
            joint.name
        );
        prop_assert!(
            (told_rad_s - velocity).abs() < 1e-9,
            "{}: reported {told_rad_s}, actual {velocity} rad/s",
            joint.name
        );
        prop_assert!(
            bounded(velocity, joint.velocity_max),
            "{}: {velocity} rad/s",
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
        self.position[i] = position;
        self.velocity[i] = velocity;
        self.acceleration_rad_s2[i] = acceleration_rad_s2;
        Ok(())
    }
}
