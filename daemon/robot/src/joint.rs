//! Limits, stiffness and inertia of one joint.

use crate::name::Name;

/// Motion of a prismatic joint that counts as one radian, m. Design choice: weights and limits for
/// radians then hold as for a revolute joint that moves the fingertip at this lever.
pub const PRISMATIC_LEVER_M: f64 = 0.1;

/// Kind of motion of a joint.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum JointKind {
    /// Turns about its axis: its coordinate is in rad.
    #[default]
    Revolute,
    /// Slides along its axis: its coordinate is in m.
    Prismatic,
}

/// Properties of one joint. Units as in [`crate::JointVector`].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Joint {
    /// Name in the URDF.
    pub name: Name,
    /// Kind of motion.
    pub kind: JointKind,
    /// Lower position limit.
    pub lower: f64,
    /// Upper position limit, above the lower one.
    pub upper: f64,
    /// Speed limit, positive.
    pub velocity_max: f64,
    /// Torque limit, not negative.
    pub effort_max: f64,
    /// Servo stiffness, N·m/rad or N/m.
    pub stiffness: f64,
    /// Inertia that the servo moves, kg·m² or kg; for simulation.
    pub inertia_kg_m2: f64,
}

impl Joint {
    /// Returns the unit of its position: `rad` or `m`.
    #[must_use]
    pub fn unit(&self) -> &'static str {
        match self.kind {
            JointKind::Revolute => "rad",
            JointKind::Prismatic => "m",
        }
    }

    /// Returns the motion that counts as one radian: 1 rad, or [`PRISMATIC_LEVER_M`].
    #[must_use]
    pub fn radian(&self) -> f64 {
        match self.kind {
            JointKind::Revolute => 1.0,
            JointKind::Prismatic => PRISMATIC_LEVER_M,
        }
    }
}
