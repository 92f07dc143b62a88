//! True state of a hand as its sensors see it.

use nalgebra::Vector3;
use robot_model::{HandModel, HandVector};

/// Physical quantities that the sensors of a hand measure.
pub(crate) trait SensedHand {
    /// Model with the true dimensions.
    fn model(&self) -> &HandModel;
    /// True joint motion.
    fn joints(&self) -> JointMotion<'_>;
    /// Writes the forces of the object on a fingertip's elements, tip frame, N.
    fn element_forces(&self, finger: usize, force_n: &mut [Vector3<f64>]);
}

/// Position, velocity and drive torque of a hand's joints; rad or m, N·m or N.
#[derive(Clone, Copy, Debug)]
pub(crate) struct JointMotion<'a> {
    pub(crate) position: &'a HandVector,
    pub(crate) velocity: &'a HandVector,
    pub(crate) effort: &'a HandVector,
}
