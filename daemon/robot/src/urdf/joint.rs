//! One moving joint of a URDF: its kind, its limits, its axis, what its robot file adds.

use std::format;

use nalgebra::{Matrix3, Vector3};
use urdf_rs::JointType;

use super::error::{Findings, Misfit, misfit};
use crate::joint::{Joint, JointKind};
use crate::name::{NAME_MAX, Name};
use crate::robot_file::JointEntry;
use crate::transform::Transform;

/// How far the length of a joint axis may be from 1: room for axes written with three decimals. Ours.
const AXIS_LENGTH_TOLERANCE: f64 = 1e-3;

/// How a joint moves.
pub(super) fn kind(urdf: &urdf_rs::Joint) -> Result<JointKind, Misfit> {
    match urdf.joint_type {
        JointType::Revolute | JointType::Continuous => Ok(JointKind::Revolute),
        JointType::Prismatic => Ok(JointKind::Prismatic),
        _ => Err(misfit(
            format!("the type of joint `{}`", urdf.name),
            format!("{:?}", urdf.joint_type),
            "a revolute, continuous, prismatic or fixed joint",
        )),
    }
}

/// A name that fits.
pub(super) fn name(text: &str) -> Result<Name, Misfit> {
    Name::new(text).ok_or_else(|| {
        let was = format!("{} bytes long", text.len());
        misfit(
            format!("the name `{text}`"),
            was,
            format!("at most {NAME_MAX}"),
        )
    })
}

/// A joint with a coordinate of its own, and where it rests.
pub(super) fn load_joint(
    urdf: &urdf_rs::Joint,
    entry: Option<&JointEntry>,
    findings: &mut Findings,
) -> Option<(Joint, f64)> {
    let label = &urdf.name;
    let Some(entry) = entry else {
        let item = format!("joint `{label}` in the robot file");
        let needs = "its stiffness and inertia under [joints]";
        findings.add(misfit(item, "missing", needs));
        return None;
    };
    let kind = findings.note(kind(urdf))?;
    let name = findings.note(name(label))?;
    let joint = Joint {
        name,
        kind,
        lower_rad: entry.lower.unwrap_or(urdf.limit.lower),
        upper_rad: entry.upper.unwrap_or(urdf.limit.upper),
        velocity_max_rad_s: entry.velocity.unwrap_or(urdf.limit.velocity),
        effort_max_n_m: entry.effort.unwrap_or(urdf.limit.effort),
        stiffness_n_m_rad: entry.stiffness,
        inertia_kg_m2: entry.inertia,
    };
    let (rest, other, needs) = match kind {
        JointKind::Revolute => (
            entry.rest_deg.map(f64::to_radians),
            entry.rest_m,
            "rest_deg",
        ),
        JointKind::Prismatic => (entry.rest_m, entry.rest_deg, "rest_m"),
    };
    if other.is_some() {
        let item = format!("the rest of joint `{label}`");
        let needs = format!("`{needs}`");
        findings.add(misfit(item, "in the other unit", needs).of_robot_file());
    }
    let rest = rest.unwrap_or(0.0);
    // What the robot file says instead of the URDF is wrong there.
    let limit_said = entry.lower.is_some() || entry.upper.is_some();
    let (speed_said, effort_said) = (entry.velocity.is_some(), entry.effort.is_some());
    let said = [limit_said, speed_said, effort_said, true, true, true];
    for (misfit, said) in unsound(label, &joint, rest).into_iter().zip(said) {
        if let Some(misfit) = misfit {
            findings.add(if said { misfit.of_robot_file() } else { misfit });
        }
    }
    let in_order = joint.lower_rad < joint.upper_rad;
    let rest = if in_order {
        rest.clamp(joint.lower_rad, joint.upper_rad)
    } else {
        rest
    };
    Some((joint, rest))
}

/// What of a joint's numbers cannot be: its limit, velocity, effort, stiffness, inertia and rest.
fn unsound(label: &str, joint: &Joint, rest: f64) -> [Option<Misfit>; 6] {
    let (unit, turning) = match joint.kind {
        JointKind::Revolute => ("rad", "N·m"),
        JointKind::Prismatic => ("m", "N"),
    };
    let (lower, upper) = (joint.lower_rad, joint.upper_rad);
    let positive = |value: f64| value.is_finite() && value > 0.0;
    let checks = [
        (
            lower.is_finite() && upper.is_finite() && lower < upper,
            format!("the limit of joint `{label}`"),
            format!("{lower} to {upper}"),
            format!("a finite lower below a finite upper ({unit})"),
        ),
        (
            positive(joint.velocity_max_rad_s),
            format!("the velocity of joint `{label}`"),
            format!("{}", joint.velocity_max_rad_s),
            format!("finite and above 0 {unit}/s"),
        ),
        (
            joint.effort_max_n_m.is_finite() && joint.effort_max_n_m >= 0.0,
            format!("the effort of joint `{label}`"),
            format!("{}", joint.effort_max_n_m),
            format!("finite and not below 0 {turning}"),
        ),
        (
            positive(joint.stiffness_n_m_rad),
            format!("the stiffness of joint `{label}`"),
            format!("{}", joint.stiffness_n_m_rad),
            format!("finite and above 0 {turning}/{unit}"),
        ),
        (
            positive(joint.inertia_kg_m2),
            format!("the inertia of joint `{label}`"),
            format!("{}", joint.inertia_kg_m2),
            format!("finite and above 0 {turning}·s²/{unit}"),
        ),
        (
            rest.is_finite(),
            format!("the rest of joint `{label}`"),
            format!("{rest}"),
            format!("a finite number ({unit})"),
        ),
    ];
    checks.map(|(sound, item, was, needs)| (!sound).then(|| misfit(item, was, needs)))
}

pub(super) fn joint_axis(urdf: &urdf_rs::Joint) -> Result<Vector3<f64>, Misfit> {
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
