//! What the drives report of the joints: positions, velocities and torques in steps, without noise.

use robot_model::{ARM_JOINTS, HAND_JOINTS, ROBOT_JOINTS, Side};
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

/// Fills in the joints of one hand.
pub(crate) fn read(plant: &Plant, side: Side, out: &mut JointState) {
    out.joint_count = ROBOT_JOINTS as u32;
    for joint in 0..HAND_JOINTS {
        let index = side.first_joint() + joint;
        let step_rad = if joint < ARM_JOINTS {
            ARM_STEP_RAD
        } else {
            FINGER_STEP_RAD
        };
        out.position_rad[index] = quantised(plant.position_rad[joint], step_rad);
        out.velocity_rad_s[index] = quantised(plant.velocity_rad_s[joint], VELOCITY_STEP_RAD_S);
        out.effort_n_m[index] = quantised(plant.effort_n_m[joint], EFFORT_STEP_N_M);
    }
}
