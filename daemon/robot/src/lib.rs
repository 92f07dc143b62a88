//! Kinematics of the two-hand-arm robot: who moves what, where the fingertips are, and which joint angles bring them
//! where a task wants them.
//!
//! A URDF goes in once, at start-up, and becomes a [`RobotModel`] of fixed size. Per tick and hand, joint angles go
//! through [`HandModel::forward`] and [`HandModel::jacobian`], and [`HandModel::ik_step`] returns the next command for a
//! [`HandTarget`], usually built from a [`GraspFrame`].
//!
//! ```text
//!  two_hand_arm.urdf ─▶ RobotModel ─▶ hand(side) ─▶ forward(q) ─▶ HandPose ─▶ jacobian ─▶ HandJacobian
//!                                                                    │                        │
//!                               GraspFrame ─▶ HandTarget ────────────┴──────── ik_step ◀──────┘ ─▶ next q
//! ```
//!
//! ```
//! # #[cfg(feature = "std")] {
//! use nalgebra::Vector3;
//! use robot_model::{GraspFrame, IkStatus, IkWeights, RobotModel, Side};
//!
//! let robot = RobotModel::two_hand_arm()?;
//! let hand = robot.hand(Side::Right);
//! let centre_m = Vector3::new(0.30, -0.10, 0.05);
//! let closing_yaw_rad = hand.closing_yaw_rad(&centre_m, 0.0);
//! let mut grasp = GraspFrame::from_above(centre_m, closing_yaw_rad, 0.06);
//! let mut q_rad = hand.posture_for(&grasp)?.q_rad;
//!
//! // One tick: both fingers close by 2 µm.
//! grasp.half_opening_m = [0.03 - 2e-6; 2];
//! let pose = hand.forward(&q_rad);
//! let step = hand.ik_step(&pose, &hand.jacobian(&pose), &grasp.target(hand), 1e-3, &IkWeights::TICK);
//! assert_eq!(step.status, IkStatus::Free);
//! q_rad = step.q_rad;
//! # assert!(hand.within_limits(&q_rad));
//! # }
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! Conventions: metres, radians, newtons. Base frame: origin on the table top under the torso, x forward, y left, z up.
//! Joint order everywhere: left 11, then right 11, as in the URDF ([`JOINT_NAMES`]); within a hand arm 5, finger 1,
//! finger 2. Finger 0 of an array is finger 1. Tip frame: see [`HandPose::base_from_tip`].
//!
//! Invariants:
//! - Nothing but loading allocates; nothing reads a clock; the same numbers give the same bits on every machine
//!   (trigonometry from `libm`, fixed order of summation).
//! - A step of the inverse kinematics is finite, keeps speed limits, and never leaves the position limits, whatever the
//!   target; a step that cannot be computed moves nothing and says so.
//! - The structure (2 × (5 + 3 + 3) revolute joints) is fixed; dimensions, axes, offsets and limits come from the URDF.
//!
//! Deliberately absent: dynamics and servos (the simulator's), trajectories and tasks (the controller's), the torso as
//! an obstacle.
//!
//! Feature `std` (default) adds the URDF loader; without it the crate is `no_std`.

#![no_std]
#![forbid(unsafe_code)]

#[cfg(feature = "std")]
extern crate std;

mod arrow;
mod capsule;
mod forward;
mod ik;
mod jacobian;
mod model;
mod reach;
mod sizes;
#[cfg(feature = "std")]
mod skeleton;
mod solve;
mod target;
mod transform;
#[cfg(feature = "std")]
mod urdf;

pub use capsule::{
    CAPSULES_MAX, Capsule, Capsules, Nearest, clearance_m, farthest_move_m, nearest,
};
pub use forward::HandPose;
pub use ik::{ACTIVE_SET_PASSES, IkStatus, IkStep, IkWeights};
pub use jacobian::{HandJacobian, Rows3, Rows6};
pub use model::{
    HandModel, JOINT_NAMES, Joint, RobotModel, Side, TIP_LINKS, TWO_HAND_ARM_URDF, finger_root,
};
pub use reach::{ReachError, Workspace};
pub use sizes::{ARM_JOINTS, FINGER_JOINTS, FINGERS, HAND_JOINTS, HandVector, ROBOT_JOINTS};
#[cfg(feature = "std")]
pub use skeleton::{Form, Limb, Placement, Shape, Skeleton};
pub use solve::{
    POSTURE_DOME_ERROR_MAX_RAD, POSTURE_ITERATIONS, POSTURE_TIP_ERROR_MAX_M, Solution, Unreachable,
};
pub use target::{GraspFrame, HandTarget};
pub use transform::Transform;
#[cfg(feature = "std")]
pub use urdf::ModelError;
