//! Normal force that two fingertips need so that an object neither slides nor rotates between them.
//!
//! Gravity acts at the centre of mass. With an offset from the closing axis, each fingertip carries
//! a moment m about its normal and a share t of the weight. The limit surface (Howe and Cutkosky
//! 1996, an ellipsoid) bounds both: (t / (μ·f))² + (m / (μ·f·r))² ≤ 1, where r is the lever of
//! friction.
//!
//! The skin is a Winkler foundation of stiffness k on a sphere of radius R. The force f = π·k·R·d²
//! indents it by d; the patch has the radius a = √(2·R·d). The pressure falls with the square of
//! the distance from the middle, which gives r = 8/15·a.

use core::f64::consts::PI;

use crate::object::Object;
use crate::pad::FOUNDATION_N_M3;
use shm_schemas::layout::DOME_RADIUS_M;

/// Lever of friction over the patch radius, for the quadratic pressure profile.
const LEVER: f64 = 8.0 / 15.0;
/// Number of bisection steps.
const STEPS: usize = 60;

impl Object {
    /// Returns the normal force per fingertip that carries the object without rotation, N. Exceeds
    /// [`Object::required_normal_n`] if the centre of mass is off the closing axis.
    #[must_use]
    pub fn required_normal_with_torsion_n(&self) -> f64 {
        let needed_n = self.required_normal_n();
        let moment_n_m = needed_n * self.friction * self.centre_of_mass_m.y.abs();
        if moment_n_m == 0.0 {
            return needed_n;
        }
        let holds = |force_n: f64| {
            let slides = needed_n / force_n;
            let turns = moment_n_m / (self.friction * force_n * lever_m(force_n));
            slides * slides + turns * turns <= 1.0
        };
        let (mut below_n, mut above_n) = (needed_n, 2.0 * needed_n);
        while !holds(above_n) {
            (below_n, above_n) = (above_n, 2.0 * above_n);
        }
        for _ in 0..STEPS {
            let middle_n = (below_n + above_n) / 2.0;
            if holds(middle_n) {
                above_n = middle_n;
            } else {
                below_n = middle_n;
            }
        }
        above_n
    }
}

/// Returns the lever of friction at a normal force, m.
pub(crate) fn lever_m(force_n: f64) -> f64 {
    let depth_m = libm::sqrt(force_n / (PI * FOUNDATION_N_M3 * DOME_RADIUS_M));
    LEVER * libm::sqrt(2.0 * DOME_RADIUS_M * depth_m)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn off_centre_object_needs_more_force() {
        let mut object = Object::built_in("wood").expect("built-in object");
        let check = |object: &Object, expected: f64| {
            let ratio = object.required_normal_with_torsion_n() / object.required_normal_n();
            assert!((ratio - expected).abs() < 0.005, "{ratio}");
        };
        check(&object, 1.0);
        object.centre_of_mass_m.x = 0.005;
        check(&object, 1.0);
        // Calculated by hand: at 6.13 N the patch radius is 5.1 mm and the lever of friction 2.7
        // mm.
        object.centre_of_mass_m.y = -0.005;
        check(&object, 2.085);
    }
}
