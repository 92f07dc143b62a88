//! One revolute joint of a URDF: its limits and its axis; and the posture that the loaded hand prefers.

use std::format;

use nalgebra::{Matrix3, Vector3};

use super::error::{ModelError, misfit};
use crate::model::{Joint, Side};
use crate::sizes::{HAND_JOINTS, HandVector};
use crate::transform::Transform;

/// How far the length of a joint axis may be from 1: room for axes written with three decimals. Ours.
const AXIS_LENGTH_TOLERANCE: f64 = 1e-3;

/// Reference posture of the right hand, degrees, in hand order; the left hand's shoulder yaw is mirrored. Source: ours,
/// over the middle of the proved workspace with the hand straight down.
const REFERENCE_RIGHT_DEG: [f64; HAND_JOINTS] = [
    25.0, -35.0, 95.0, 30.0, 0.0, 0.0, -20.0, 50.0, 0.0, -20.0, 50.0,
];

/// The reference posture of a side, moved inside the limits of `joints`, radians.
pub(super) fn reference_rad(side: Side, joints: &[Joint; HAND_JOINTS]) -> HandVector {
    let mut wanted = HandVector::from(REFERENCE_RIGHT_DEG).map(f64::to_radians);
    wanted[0] *= -side.y_sign();
    HandVector::from_fn(|index, _| {
        wanted[index].clamp(joints[index].lower_rad, joints[index].upper_rad)
    })
}

pub(super) fn load_joint(name: &'static str, urdf: &urdf_rs::Joint) -> Result<Joint, ModelError> {
    let limit = &urdf.limit;
    if !(limit.lower.is_finite() && limit.upper.is_finite() && limit.lower < limit.upper) {
        let was = format!("{} to {}", limit.lower, limit.upper);
        return Err(misfit(
            format!("the limit of joint `{name}`"),
            was,
            "a finite lower below a finite upper (rad)",
        ));
    }
    if !(limit.velocity.is_finite() && limit.velocity > 0.0) {
        return Err(misfit(
            format!("the velocity of joint `{name}`"),
            limit.velocity,
            "finite and above 0 rad/s",
        ));
    }
    if !(limit.effort.is_finite() && limit.effort >= 0.0) {
        return Err(misfit(
            format!("the effort of joint `{name}`"),
            limit.effort,
            "finite and not below 0 N·m",
        ));
    }
    Ok(Joint {
        name,
        lower_rad: limit.lower,
        upper_rad: limit.upper,
        velocity_max_rad_s: limit.velocity,
        effort_max_n_m: limit.effort,
    })
}

pub(super) fn joint_axis(urdf: &urdf_rs::Joint) -> Result<Vector3<f64>, ModelError> {
    let axis = Vector3::from(urdf.axis.xyz.0);
    let length = axis.norm();
    // Written so that NaN is refused.
    if (length - 1.0).abs() <= AXIS_LENGTH_TOLERANCE {
        return Ok(axis / length);
    }
    let was = format!("({}, {}, {}) of length {length}", axis.x, axis.y, axis.z);
    Err(misfit(
        format!("the axis of joint `{}`", urdf.name),
        was,
        "a unit vector",
    ))
}

/// A rotation whose z is `axis`; its x is the base vector farthest from the axis, made normal to it. An axis along a base
/// vector gives an exact permutation matrix.
pub(super) fn turn_z_to(axis: Vector3<f64>) -> Transform {
    let farthest = axis.iamin();
    let x = (Vector3::ith(farthest, 1.0) - axis * axis[farthest]).normalize();
    Transform {
        rotation: Matrix3::from_columns(&[x, axis.cross(&x), axis]),
        ..Transform::IDENTITY
    }
}
