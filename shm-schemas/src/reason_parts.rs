//! Parts of the texts of reasons: labels of joints, display units, alternatives.

use crate::body::BodyPair;
use crate::fields::GoalField;
use crate::goal::GoalKind;
use core::fmt::{self, Display};

/// Name and unit of the joint that a reason concerns, for programs that know the robot.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct JointLabel<'a> {
    /// Name of the joint in the robot's URDF.
    pub name: &'a str,
    /// Unit of its position: `rad` or `m`.
    pub unit: &'a str,
}

/// Name and unit of a joint, from its label if known.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Joints<'a>(pub(crate) Option<JointLabel<'a>>);

impl Joints<'_> {
    /// Returns the name of a joint, or its index.
    pub(crate) fn name(self, joint: usize) -> impl Display {
        fmt::from_fn(move |f| match self.0 {
            Some(label) => f.write_str(label.name),
            None => write!(f, "{joint}"),
        })
    }

    /// Returns a position with its unit.
    pub(crate) fn with_unit(self, position: f64) -> impl Display {
        let unit = self.0.map_or("rad or m", |label| label.unit);
        fmt::from_fn(move |f| write!(f, "{position:.4} {unit}"))
    }
}

pub(crate) fn mm(length_m: f64) -> f64 {
    length_m * 1e3
}

pub(crate) fn ms(time_ns: f64) -> f64 {
    time_ns * 1e-6
}

/// Returns the number of a fingertip or grasp side as users count it, from 1.
pub(crate) fn number(index: usize) -> usize {
    index.saturating_add(1)
}

pub(crate) fn goal_text(kind: Option<GoalKind>) -> impl Display {
    fmt::from_fn(move |f| match kind {
        Some(kind) => write!(f, "the goal `{kind}`"),
        None => f.write_str("another goal"),
    })
}

/// Returns how long nothing has arrived.
pub(crate) fn silence_text(age_ns: Option<f64>, limit_ns: f64) -> impl Display {
    let limit_ms = ms(limit_ns);
    fmt::from_fn(move |f| match age_ns.map(ms) {
        Some(age_ms) => write!(f, "for {age_ms:.1} ms, allowed {limit_ms:.1} ms"),
        None => f.write_str("yet"),
    })
}

pub(crate) fn collision_text(bodies: Option<BodyPair>, gap_m: f64, limit_m: f64) -> impl Display {
    let (gap_mm, limit_mm) = (mm(gap_m), mm(limit_m));
    fmt::from_fn(move |f| match bodies {
        Some(BodyPair([ours, theirs])) => write!(
            f,
            "the {ours} would come within {gap_mm:.1} mm of the {theirs}, needs {limit_mm:.1} mm; \
             move the places apart, or the other arm away"
        ),
        None => write!(
            f,
            "the arms would come within {gap_mm:.1} mm of each other, needs {limit_mm:.1} mm; \
             move the places apart"
        ),
    })
}

pub(crate) fn unreachable_text(field: GoalField, value: f64, limit: f64) -> impl Display {
    let (is, bound) = (field.with_unit(value), field.with_unit(limit));
    fmt::from_fn(move |f| match field {
        field if field.is_yaw() => write!(
            f,
            "closing direction out of reach: {field} is {is}, the nearest possible is {bound}; \
             turn the closing axis or move the place"
        ),
        GoalField::LIFT => write!(
            f,
            "lift too high: place and lift together are {is} high, the limit is {bound}; lift less"
        ),
        _ => write!(
            f,
            "goal out of reach: {field} is {is}, the limit is {bound}; use at {} {bound}",
            if value < limit { "least" } else { "most" }
        ),
    })
}
