//! File sections of caps and bottles, and their validation.

use serde::Deserialize;

use super::{Neck, ObjectError, check_range};
use crate::shape::Shape;
use crate::thread::{ClosingDirection, Thread};

/// Allowed values. Design choice: around the task families, within the thread model's limits at 250
/// µs.
mod range {
    pub(super) const FRICTION_N_M: [f64; 2] = [0.001, 0.2];
    pub(super) const CLOSING_DEG: [f64; 2] = [30.0, 1440.0];
    pub(super) const PITCH_M: [f64; 2] = [0.0005, 0.01];
    /// Height above the shoulder. A cap's mid-height is at least 20 mm above the shoulder (robot
    /// design).
    pub(super) const NECK_M: [f64; 2] = [0.01, 0.05];
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ThreadFile {
    friction_n_m: f64,
    closing_deg: f64,
    pitch_m: f64,
    #[serde(default)]
    closes: ClosingDirection,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct NeckFile {
    rim_m: f64,
}

impl ThreadFile {
    pub(super) fn validate(self, shape: &Shape, origin: &str) -> Result<Thread, ObjectError> {
        check_cylinder(shape, origin)?;
        let check = |key, value, range| check_range(origin, key, value, range);
        let closing_deg = check("thread.closing_deg", self.closing_deg, range::CLOSING_DEG)?;
        Ok(Thread {
            friction_n_m: check(
                "thread.friction_n_m",
                self.friction_n_m,
                range::FRICTION_N_M,
            )?,
            closing_rad: closing_deg.to_radians(),
            pitch_m: check("thread.pitch_m", self.pitch_m, range::PITCH_M)?,
            closes: self.closes,
        })
    }
}

impl NeckFile {
    pub(super) fn validate(self, shape: &Shape, origin: &str) -> Result<Neck, ObjectError> {
        check_cylinder(shape, origin)?;
        let shoulder_m = 2.0 * shape.half_height_m();
        let neck_m = range::NECK_M.map(|neck_m| shoulder_m + neck_m);
        let rim_m = check_range(origin, "neck.rim_m", self.rim_m, neck_m)?;
        Ok(Neck { rim_m })
    }
}

fn check_cylinder(shape: &Shape, origin: &str) -> Result<(), ObjectError> {
    match shape {
        Shape::Cylinder { .. } => Ok(()),
        Shape::Box { .. } => Err(ObjectError::Malformed {
            origin: origin.into(),
            message: "caps and bottles need shape.kind = \"cylinder\"".to_owned(),
        }),
    }
}
