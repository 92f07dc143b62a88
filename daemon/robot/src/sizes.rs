//! Size limits of a robot: capacities of all fixed-size data.

/// Joints of an arm; it may have none (a gripper on a stand).
pub const ARM_JOINTS_MAX: usize = 7;
/// Fingertips of a hand.
pub const FINGERTIPS_MAX: usize = 4;
/// Joints that move one fingertip against the palm, mimic joints included.
pub const FINGER_JOINTS_MAX: usize = 4;
/// Joints of a hand with its arm.
pub const HAND_JOINTS_MAX: usize = 16;
/// Joints of a robot.
pub const ROBOT_JOINTS_MAX: usize = 2 * HAND_JOINTS_MAX;
/// Joints that move more than one fingertip: those of the arm, and two drives that fingers share.
pub(crate) const TRUNK_JOINTS_MAX: usize = ARM_JOINTS_MAX + 2;
/// Frames that move: those of the arm and of every finger, mimic joints included.
pub(crate) const FRAMES_MAX: usize = ARM_JOINTS_MAX + FINGERTIPS_MAX * FINGER_JOINTS_MAX;

/// Grasp sides. Source: two opposing virtual fingers (Arbib, Iberall and Lyons 1985). Each stands
/// for one or more fingertips that press together.
pub const GRASP_SIDES: usize = 2;
