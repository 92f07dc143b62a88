//! Loads one moving joint: kind, limits and axis from the URDF, servo and rest from the robot file.

use std::format;

use nalgebra::{Matrix3, Vector3};
use urdf_rs::JointType;

use super::error::{Findings, ModelProblem, problem};
use crate::joint::{Joint, JointKind};
use crate::name::{NAME_MAX, Name};
use crate::robot_file::JointEntry;
use crate::transform::Transform;

/// Tolerance of the length of a joint axis around 1, for axes written with three decimals. Design
/// choice.
const AXIS_LENGTH_TOLERANCE: f64 = 1e-3;

/// Returns the kind of motion of a joint.
pub(super) fn kind(urdf: &urdf_rs::Joint) -> Result<JointKind, ModelProblem> {
    match urdf.joint_type {
        JointType::Revolute | JointType::Continuous => Ok(JointKind::Revolute),
        JointType::Prismatic => Ok(JointKind::Prismatic),
        _ => Err(problem(
            format!("the type of joint `{}`", urdf.name),
            format!("{:?}", urdf.joint_type),
            "a revolute, continuous, prismatic or fixed joint",
        )),
    }
}

/// Returns the name if it is short enough.
pub(super) fn name(text: &str) -> Result<Name, ModelProblem> {
    Name::new(text).ok_or_else(|| {
        let was = format!("{} bytes long", text.len());
        problem(
            format!("the name `{text}`"),
            was,
            format!("at most {NAME_MAX}"),
        )
    })
}

/// Returns a joint with a coordinate, and its rest position.
pub(super) fn load_joint(
    urdf: &urdf_rs::Joint,
    entry: Option<&JointEntry>,
    findings: &mut Findings,
) -> Option<(Joint, f64)> {
    let label = &urdf.name;
    let Some(entry) = entry else {
        let item = format!("the entry of joint `{label}` in [joints]");
        let needs = "stiffness and inertia of its servo";
        findings.add(problem(item, "missing", needs).in_robot_file());
        return None;
    };
    let kind = findings.value_of(kind(urdf))?;
    let name = findings.value_of(name(label))?;
    let joint = Joint {
        name,
        kind,
        lower: entry.lower.unwrap_or(urdf.limit.lower),
        upper: entry.upper.unwrap_or(urdf.limit.upper),
        velocity_max: entry.velocity.unwrap_or(urdf.limit.velocity),
        effort_max: entry.effort.unwrap_or(urdf.limit.effort),
        stiffness: entry.stiffness,
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
        findings.add(problem(item, "in the other unit", needs).in_robot_file());
    }
    let rest = rest.unwrap_or(0.0);
    // Limits in the robot file replace those of the URDF; errors then belong to the robot file.
    let limit_said = entry.lower.is_some() || entry.upper.is_some();
    let (speed_said, effort_said) = (entry.velocity.is_some(), entry.effort.is_some());
    let message = [limit_said, speed_said, effort_said, true, true, true];
    for (issue, message) in invalid_values(label, &joint, rest).into_iter().zip(message) {
        if let Some(issue) = issue {
            findings.add(if message {
                issue.in_robot_file()
            } else {
                issue
            });
        }
    }
    let in_order = joint.lower < joint.upper;
    let rest = if in_order {
        rest.clamp(joint.lower, joint.upper)
    } else {
        rest
    };
    Some((joint, rest))
}

/// Returns the invalid values of a joint: limit, velocity, effort, stiffness, inertia and rest.
fn invalid_values(label: &str, joint: &Joint, rest: f64) -> [Option<ModelProblem>; 6] {
    let (unit, turning) = match joint.kind {
        JointKind::Revolute => ("rad", "N·m"),
        JointKind::Prismatic => ("m", "N"),
    };
    let (lower, upper) = (joint.lower, joint.upper);
    let positive = |value: f64| value.is_finite() && value > 0.0;
    let checks = [
        (
            lower.is_finite() && upper.is_finite() && lower < upper,
            format!("the limit of joint `{label}`"),
            format!("{lower} to {upper}"),
            format!("a finite lower below a finite upper ({unit})"),
        ),
        (
            positive(joint.velocity_max),
            format!("the velocity of joint `{label}`"),
            format!("{}", joint.velocity_max),
            format!("finite and above 0 {unit}/s"),
        ),
        (
            joint.effort_max.is_finite() && joint.effort_max >= 0.0,
            format!("the effort of joint `{label}`"),
            format!("{}", joint.effort_max),
            format!("finite and not below 0 {turning}"),
        ),
        (
            positive(joint.stiffness),
            format!("the stiffness of joint `{label}`"),
            format!("{}", joint.stiffness),
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
    checks.map(|(sound, item, was, needs)| (!sound).then(|| problem(item, was, needs)))
}

pub(super) fn joint_axis(urdf: &urdf_rs::Joint) -> Result<Vector3<f64>, ModelProblem> {
    let axis = Vector3::from(urdf.axis.xyz.0);
    let length = axis.norm();
    // This form rejects NaN.
    if (length - 1.0).abs() <= AXIS_LENGTH_TOLERANCE {
        return Ok(axis / length);
    }
    let was = format!("({}, {}, {}) of length {length}", axis.x, axis.y, axis.z);
    Err(problem(
        format!("the axis of joint `{}`", urdf.name),
        was,
        "a unit vector",
    ))
}

/// Returns a rotation whose z is `axis`. Its x is the base vector farthest from the axis, made
/// normal to it. An axis along a base vector gives an exact permutation matrix.
pub(super) fn turn_z_to(axis: Vector3<f64>) -> Transform {
    let farthest = axis.iamin();
    let x = (Vector3::ith(farthest, 1.0) - axis * axis[farthest]).normalize();
    Transform {
        rotation: Matrix3::from_columns(&[x, axis.cross(&x), axis]),
        ..Transform::IDENTITY
    }
}
