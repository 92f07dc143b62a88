//! What the drives report of the joints: positions, velocities and torques in steps, without noise.

use robot_model::HandModel;
use shm_schemas::JointState;

use crate::plant::Plant;
use crate::sensor::quantised;

/// Step of an arm joint's encoder, rad: 20 bits per turn. At the 0.5 m reach of the arm 3 µm at the tip.
const ARM_STEP_RAD: f64 = core::f64::consts::TAU / (1 << 20) as f64;
/// Step of a finger joint's encoder, rad: 18 bits per turn. At the 90 mm from knuckle to tip 2.2 µm: the position quantum
/// of the tactile design.
const FINGER_STEP_RAD: f64 = core::f64::consts::TAU / (1 << 18) as f64;
/// Step of a measured velocity, rad/s. Ours: the resolution of a drive's own observer.
const VELOCITY_STEP_RAD_S: f64 = 1e-3;
/// Step of a measured torque, N·m. Ours.
const EFFORT_STEP_N_M: f64 = 1e-3;

/// Fills in the joints of one hand behind those that are there.
pub(crate) fn read(plant: &Plant, model: &HandModel, out: &mut JointState) {
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
        out.position_rad[index] = quantised(plant.position_rad[joint], step_rad * unit);
        out.velocity_rad_s[index] =
            quantised(plant.velocity_rad_s[joint], VELOCITY_STEP_RAD_S * unit);
        out.effort_n_m[index] = quantised(plant.effort_n_m[joint], EFFORT_STEP_N_M);
    }
}
