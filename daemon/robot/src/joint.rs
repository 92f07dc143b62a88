//! What one joint can do.

use crate::name::Name;

/// How far a prismatic joint moves for what counts as a radian, m. Ours: weights and limits that are written for radians
/// hold for a prismatic joint as they would for a revolute one that moves the fingertip at this lever.
pub const PRISMATIC_LEVER_M: f64 = 0.1;

/// How a joint moves.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum JointKind {
    /// Turns about its axis: its coordinate is in rad.
    #[default]
    Revolute,
    /// Slides along its axis: its coordinate is in m.
    Prismatic,
}

/// One joint: its name and what it can do. Units as [`crate::JointVector`] has them.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Joint {
    /// Its name in the URDF.
    pub name: Name,
    /// How it moves.
    pub kind: JointKind,
    /// Lower position limit.
    pub lower_rad: f64,
    /// Upper position limit, above the lower one.
    pub upper_rad: f64,
    /// Speed limit, positive.
    pub velocity_max_rad_s: f64,
    /// Torque limit, not negative.
    pub effort_max_n_m: f64,
    /// Stiffness of its servo, N·m/rad or N/m.
    pub stiffness_n_m_rad: f64,
    /// Inertia that its servo moves, kg·m² or kg: for simulation.
    pub inertia_kg_m2: f64,
}

impl Joint {
    /// What counts as a radian for this joint: 1 rad, or [`PRISMATIC_LEVER_M`].
    #[must_use]
    pub fn radian(&self) -> f64 {
        match self.kind {
            JointKind::Revolute => 1.0,
            JointKind::Prismatic => PRISMATIC_LEVER_M,
        }
    }
}
