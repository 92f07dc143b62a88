//! Random values of a trial.

use serde::{Deserialize, Serialize};
use sim_backend::Scene;

/// Random values drawn from families and errors, for the first object of a trial.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Drawn {
    pub(crate) noise: f64,
    pub(crate) mass_kg: f64,
    pub(crate) friction: f64,
    pub(crate) stiffness_n_m: f64,
    pub(crate) width_mm: f64,
    pub(crate) expected_width_mm: f64,
    pub(crate) height_mm: f64,
    pub(crate) off_centre_mm: f64,
    pub(crate) off_x_mm: f64,
    pub(crate) off_y_mm: f64,
    pub(crate) off_yaw_deg: f64,
    pub(crate) thread_mn_m: Option<f64>,
    pub(crate) closes_at_deg: Option<f64>,
}

impl Drawn {
    /// Collects the values of a scene; `None` without an object.
    pub(crate) fn from_scene(scene: &Scene) -> Option<Self> {
        let (placed, reported) = (scene.objects.first()?, scene.grasp_hint(0)?);
        let object = &placed.object;
        let off_mm = |axis: usize| (placed.position_m[axis] - reported.from_m[axis]) * 1e3;
        Some(Self {
            noise: scene.noise_factor,
            mass_kg: object.mass_kg,
            friction: object.friction,
            stiffness_n_m: object.stiffness_n_m,
            width_mm: object.shape.width_m() * 1e3,
            expected_width_mm: reported.width_m * 1e3,
            height_mm: 2e3 * object.shape.half_height_m(),
            off_centre_mm: object.centre_of_mass_m.y * 1e3,
            off_x_mm: off_mm(0),
            off_y_mm: off_mm(1),
            off_yaw_deg: (placed.yaw_rad - reported.yaw_rad).to_degrees(),
            thread_mn_m: object.thread.map(|thread| thread.friction_n_m * 1e3),
            closes_at_deg: object.thread.map(|thread| thread.closing_rad.to_degrees()),
        })
    }
}
