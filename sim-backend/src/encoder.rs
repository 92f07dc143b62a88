//! Joint feedback of the drives: quantised positions, velocities and torques, without noise.

use robot_model::HandModel;
use shm_schemas::JointState;

use crate::sensed_hand::JointMotion;
use crate::sensor::quantised;

/// Encoder step of an arm joint, rad: 20 bits per turn, 3 µm at the tip (0.5 m reach).
const ARM_STEP_RAD: f64 = core::f64::consts::TAU / (1 << 20) as f64;
/// Encoder step of a finger joint, rad: 18 bits per turn, 2.2 µm at the tip (90 mm from the
/// knuckle). Equals the position quantum of the tactile design.
const FINGER_STEP_RAD: f64 = core::f64::consts::TAU / (1 << 18) as f64;
/// Step of a measured velocity, rad/s or m/s. Design choice: resolution of a drive's observer.
const VELOCITY_STEP_RAD_S: f64 = 1e-3;
/// Step of a measured torque, N·m. Design choice.
const EFFORT_STEP_N_M: f64 = 1e-3;

/// Appends the joints of one hand to `out`.
pub(crate) fn append_joints(joints: &JointMotion<'_>, model: &HandModel, out: &mut JointState) {
    let first = out.joint_count as usize;
    out.joint_count += model.joints().len() as u32;
    for (joint, of_joint) in model.joints().iter().enumerate() {
        let index = first + joint;
        let unit = of_joint.radian();
        let step_rad = if model.arm_joints().contains(&joint) {
            ARM_STEP_RAD
        } else {
            FINGER_STEP_RAD
        };
        out.position[index] = quantised(joints.position[joint], step_rad * unit);
        out.velocity[index] = quantised(joints.velocity[joint], VELOCITY_STEP_RAD_S * unit);
        out.effort[index] = quantised(joints.effort[joint], EFFORT_STEP_N_M);
    }
}
