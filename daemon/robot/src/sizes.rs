//! How large a robot may be: everything of fixed size has these bounds, and a count of what is in use.

/// Joints of an arm; it may have none (a gripper on a stand).
pub const ARM_JOINTS_MAX: usize = 7;
/// Fingertips of a hand.
pub const FINGERS_MAX: usize = 4;
/// Joints that move one fingertip against the palm, mimic joints included.
pub const FINGER_JOINTS_MAX: usize = 4;
/// Joints of a hand with its arm.
pub const HAND_JOINTS_MAX: usize = 16;
/// Joints of a robot.
pub const ROBOT_JOINTS_MAX: usize = 2 * HAND_JOINTS_MAX;
/// Joints that move more than one fingertip: those of the arm, and two drives that fingers share.
pub(crate) const TRUNK_JOINTS_MAX: usize = ARM_JOINTS_MAX + 2;
/// Frames that move: those of the arm and of every finger, mimic joints included.
pub(crate) const FRAMES_MAX: usize = ARM_JOINTS_MAX + FINGERS_MAX * FINGER_JOINTS_MAX;

/// Sides from which a grasp presses. Source: opposing virtual fingers (Arbib, Iberall and Lyons 1985): each stands for
/// one or more fingertips that press together.
pub const VIRTUAL_FINGERS: usize = 2;
