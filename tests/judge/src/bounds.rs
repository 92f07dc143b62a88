//! Limits of the joints, given by the test.

use shm_schemas::capacity::JOINTS;

/// Unit of a joint's position; speed, acceleration and jerk follow from it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum JointUnit {
    /// Revolute joint: rad.
    #[default]
    Radian,
    /// Prismatic joint: m.
    Metre,
}

impl JointUnit {
    /// Returns the symbol of the unit.
    #[must_use]
    pub fn symbol(self) -> &'static str {
        match self {
            Self::Radian => "rad",
            Self::Metre => "m",
        }
    }
}

/// Limits of one joint, in its unit: rad or m, with s, s² and s³.
#[derive(Clone, Debug, PartialEq)]
pub struct JointBounds {
    /// Name in the texts.
    pub name: String,
    /// Unit of the position.
    pub unit: JointUnit,
    /// Lower position limit.
    pub lower: f64,
    /// Upper position limit.
    pub upper: f64,
    /// Speed limit, positive.
    pub speed_max: f64,
    /// Acceleration limit, positive.
    pub acceleration_max: f64,
    /// Jerk limit, positive.
    pub jerk_max: f64,
}

impl JointBounds {
    /// Checks that all limits are finite and consistent.
    pub(crate) fn check(&self) -> Result<(), BoundsError> {
        let error = |field, value, must| BoundsError::Value {
            joint: self.name.clone(),
            field,
            value,
            must,
        };
        for (field, value) in [("lower", self.lower), ("upper", self.upper)] {
            if !value.is_finite() {
                return Err(error(field, value, "be finite"));
            }
        }
        if self.upper <= self.lower {
            return Err(error("upper", self.upper, "be above `lower`"));
        }
        let positive = [
            ("speed_max", self.speed_max),
            ("acceleration_max", self.acceleration_max),
            ("jerk_max", self.jerk_max),
        ];
        let bad = positive
            .into_iter()
            .find(|(_, value)| !value.is_finite() || *value <= 0.0);
        bad.map_or(Ok(()), |(field, value)| {
            Err(error(field, value, "be finite and positive"))
        })
    }
}

/// Reason why a judge could not be created.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum BoundsError {
    /// No joints, or more than a command contains.
    #[error("judge not created: {count} joints; a command contains 1 to {JOINTS}, check the robot")]
    JointCount {
        /// Number of joints.
        count: usize,
    },
    /// Invalid limit of a joint.
    #[error("judge not created: `{field}` of joint {joint:?} is {value}; it must {must}")]
    Value {
        /// Name of the joint.
        joint: String,
        /// Field of [`JointBounds`].
        field: &'static str,
        /// Its value.
        value: f64,
        /// Violated rule.
        must: &'static str,
    },
    /// Duration of zero.
    #[error("judge not created: `{field}` is 0 ns; give the {meaning}")]
    Duration {
        /// Argument of [`crate::Judge::new`].
        field: &'static str,
        /// Its meaning.
        meaning: &'static str,
    },
}
