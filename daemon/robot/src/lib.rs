//! Kinematics of robots with one or two hands: forward kinematics, Jacobians and inverse
//! kinematics.
//!
//! A URDF and its robot file become a [`RobotModel`] of fixed size at start-up. Per tick and hand,
//! joint positions go through [`HandModel::forward`] and [`HandModel::jacobian`].
//! [`HandModel::ik_step`] then returns the next command for a [`HandTarget`], usually built from a
//! [`GraspPose`].
//!
//! ```text
//!  robot.urdf ┐
//!  robot.toml ┴▶ RobotModel ─▶ hand(side) ─▶ forward(q) ─▶ HandPose ─▶ jacobian ─▶ HandJacobian
//!                                                              │                        │
//!                        GraspPose ─▶ HandTarget ────────────┴────── ik_step ◀──────┘ ─▶ next q
//! ```
//!
//! ```
//! # #[cfg(feature = "std")] {
//! use nalgebra::Vector3;
//! use robot_model::{GraspPose, HandSide, IkStatus, IkWeights, PerSide, RobotModel};
//!
//! let robot = RobotModel::two_hand_arm()?;
//! let hand = robot.hand(HandSide::Right);
//! let centre_m = Vector3::new(0.30, -0.10, 0.05);
//! let closing_yaw_rad = hand.closing_yaw_rad(&centre_m, 0.0);
//! let mut grasp = GraspPose::from_above(centre_m, closing_yaw_rad, 0.06);
//! let mut q = hand.posture_for(&grasp)?.q;
//!
//! // One tick: both fingers close by 2 µm.
//! grasp.half_opening_m = PerSide::repeat(0.03 - 2e-6);
//! let pose = hand.forward(&q);
//! let (jacobian, target) = (hand.jacobian(&pose), grasp.target(hand));
//! let step = hand.ik_step(&pose, &jacobian, &target, 1e-3, &IkWeights::TICK);
//! assert_eq!(step.status, IkStatus::Free);
//! q = step.q;
//! # assert!(hand.within_limits(&q));
//! # }
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! Conventions: metres, radians, newtons; units of joint coordinates as in [`JointVector`]. Base
//! frame: the URDF's root, origin on the table top, x forward, y left, z up. Joint order: left
//! hand, then right; within a hand as in [`HandModel`]. Index 0 of a fingertip array is finger 1.
//! Tip frame: see [`HandPose::base_from_tip`].
//!
//! Invariants:
//! - Only loading allocates. No function reads a clock. Equal inputs give equal bits on every
//!   machine (trigonometry from `libm`, fixed order of summation).
//! - A step of the inverse kinematics is finite, keeps speed limits and position limits for every
//!   target. A step that cannot be computed moves nothing and reports this.
//! - All data of a robot come from its two files, within the limits of `sizes.rs`.
//!
//! Not included: dynamics and servos (simulator), trajectories and tasks (controller), the torso as
//! an obstacle.
//!
//! Feature `std` (default) adds the loader; without it the crate is `no_std`.

#![no_std]
#![forbid(unsafe_code)]

#[cfg(feature = "std")]
extern crate std;

mod arrow;
mod bearing;
mod capabilities;
mod capsule;
#[cfg(feature = "std")]
mod files;
mod forward;
mod grasp_sides;
mod ik;
mod jacobian;
mod joint;
mod model;
mod name;
mod pinch_pose;
mod robot;
#[cfg(feature = "std")]
mod robot_file;
#[cfg(feature = "std")]
mod robot_file_parser;
mod side;
mod sizes;
#[cfg(feature = "std")]
mod skeleton;
mod skin;
mod solve;
mod target;
mod transform;
mod turning;
#[cfg(feature = "std")]
mod urdf;
mod vector;
mod workspace;

pub use capabilities::Capabilities;
pub use capsule::{
    CAPSULES_MAX, Capsule, Capsules, Nearest, clearance_m, farthest_move_m, nearest,
};
#[cfg(feature = "std")]
pub use files::{RobotFiles, SHIPPED, TWO_HAND_ARM, shipped_names};
pub use forward::HandPose;
pub use grasp_sides::{GraspSide, GraspSides, PerSide};
pub use ik::{ACTIVE_SET_PASSES, IkStatus, IkStep, IkWeights};
pub use jacobian::{HandJacobian, Rows3, TipJacobian};
pub use joint::{Joint, JointKind, PRISMATIC_LEVER_M};
pub use model::{Frame, HandModel, Mounted, Mover};
pub use name::{NAME_MAX, Name};
pub use pinch_pose::PinchPose;
pub use robot::RobotModel;
#[cfg(feature = "std")]
pub use robot_file::{
    FingerEntry, HandEntry, Hands, JointEntry, RobotFile, SkinEntry, WorkspaceEntry,
};
#[cfg(feature = "std")]
pub use robot_file_parser::{RobotFileError, RobotFileErrors};
pub use side::HandSide;
pub use sizes::{
    ARM_JOINTS_MAX, FINGER_JOINTS_MAX, FINGERTIPS_MAX, GRASP_SIDES, HAND_JOINTS_MAX,
    ROBOT_JOINTS_MAX,
};
#[cfg(feature = "std")]
pub use skeleton::{Form, Limb, MeshFile, Placement, Shape, Skeleton};
pub use skin::{Compression, Skin};
pub use solve::{
    POSTURE_DOME_ERROR_MAX_RAD, POSTURE_ITERATIONS, POSTURE_SPREAD_ERROR_MAX_M,
    POSTURE_TIP_ERROR_MAX_M, Solution, Unreachable,
};
pub use target::{GraspPose, HandTarget};
pub use transform::Transform;
#[cfg(feature = "std")]
pub use urdf::{ModelError, ModelFile, ModelProblem};
pub use vector::{HandVector, JointVector, RobotVector};
pub use workspace::Workspace;

/// Tests of the programs in the README.
#[cfg(all(doctest, feature = "std"))]
#[doc = include_str!("../README.md")]
struct Readme;
