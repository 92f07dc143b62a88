//! How many joints there are: everything else has these sizes.

/// Joints of an arm: shoulder yaw and pitch, elbow pitch, wrist pitch and roll (paper: arm 5 DOF).
pub const ARM_JOINTS: usize = 5;
/// Joints of a finger: root, knuckle, distal (paper: finger 3 DOF).
pub const FINGER_JOINTS: usize = 3;
/// Fingers of a hand. Ours.
pub const FINGERS: usize = 2;
/// Joints of one arm with its hand.
pub const HAND_JOINTS: usize = ARM_JOINTS + FINGERS * FINGER_JOINTS;
/// Joints of the robot.
pub const ROBOT_JOINTS: usize = 2 * HAND_JOINTS;

/// One value per joint of a hand, in hand order.
pub type HandVector = nalgebra::SVector<f64, HAND_JOINTS>;
