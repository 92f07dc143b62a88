//! Forces that decide whether an object can be held.

use atas_core::settings;
use atas_core::thresholds::Thresholds;
use serde::{Deserialize, Serialize};
use sim_backend::{GraspHint, Object, Placed};

/// Relative distance from F_2 within which an object is borderline. Measured with
/// `atas eval grasp --seeds 25`: for soft objects the stiffness probe overestimates F_2 by 5 to 9
/// %, with a standard deviation of 4 %.
const BORDERLINE_SHARE: f64 = 0.15;

/// Forces that decide whether an object can be held, N per grasp side.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Load {
    /// Normal force that holds the object by friction: m·g / (2·μ), true static friction.
    pub needed_n: f64,
    /// Normal force that also prevents rotation between the fingertips
    /// ([`Object::required_normal_with_torsion_n`]).
    pub steady_n: f64,
    /// Normal force against rotation in a two-dome grasp, with the grasp's position error.
    pub gripped_n: f64,
    /// Normal force that crushes the object.
    pub crush_n: f64,
    /// Maximum force of the hand (`grasp.f2_max_n`), for any object.
    pub hand_max_n: f64,
    /// F_2 for the true stiffness.
    pub f2_n: f64,
}

impl Load {
    /// Computes the forces of a true object for a hand with these settings. Stiffness and crush
    /// force scale with `tips`, the smaller fingertip count of both sides.
    #[must_use]
    pub fn from_object(object: &Object, grasp: &settings::Grasp, tips: usize) -> Self {
        let tips = tips as f64;
        Self {
            needed_n: object.required_normal_n(),
            steady_n: object.required_normal_with_torsion_n(),
            gripped_n: object.required_normal_with_torsion_n(),
            crush_n: object.crush_n * tips,
            hand_max_n: grasp.f2_max_n,
            f2_n: Thresholds::for_stiffness(object.stiffness_n_m * tips, grasp).f2_n,
        }
    }

    /// Updates `gripped_n` for the true position of the object relative to the expected one.
    #[must_use]
    pub fn with_position_error(self, placed: &Placed, reported: GraspHint) -> Self {
        let [off_x_m, off_y_m] = [0, 1].map(|axis| placed.position_m[axis] - reported.from_m[axis]);
        // Across the closing axis. An error along it does not matter: the fingers close until
        // contact.
        let beside_m = reported.yaw_rad.cos() * off_y_m - reported.yaw_rad.sin() * off_x_m;
        let mut object = placed.object.clone();
        object.centre_of_mass_m.y += beside_m;
        Self {
            gripped_n: object.required_normal_with_torsion_n(),
            ..self
        }
    }

    /// Returns true if the needed force is below F_2 and the crush force (the paper's rule).
    #[must_use]
    pub fn is_feasible(&self) -> bool {
        self.needed_n < self.f2_n && self.needed_n < self.crush_n
    }

    /// Returns true if the force against rotation is below the crush force and the hand's maximum.
    #[must_use]
    pub fn is_physically_feasible(&self) -> bool {
        self.steady_n < self.crush_n && self.steady_n < self.hand_max_n
    }

    /// Returns true if measurement errors of the stiffness may change the feasibility.
    #[must_use]
    pub fn is_borderline(&self) -> bool {
        (self.needed_n / self.f2_n - 1.0).abs() < BORDERLINE_SHARE
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use robot_model::HandSide;
    use sim_backend::Scene;

    #[test]
    fn feasibility_under_the_rule() {
        let check = |needed_n, crush_n, f2_n, feasible, borderline| {
            let load = Load {
                needed_n,
                steady_n: needed_n,
                gripped_n: needed_n,
                crush_n,
                hand_max_n: 8.0,
                f2_n,
            };
            assert_eq!(
                (load.is_feasible(), load.is_borderline()),
                (feasible, borderline),
                "{load:?}"
            );
        };
        check(2.9, f64::INFINITY, 8.0, true, false);
        check(18.4, f64::INFINITY, 8.0, false, false);
        check(1.47, 1.5, 0.75, false, false);
        check(0.25, 1.5, 0.75, true, false);
        check(1.6, 1.5, 8.0, false, false);
        check(7.9, f64::INFINITY, 8.0, true, true);
        check(8.0, f64::INFINITY, 8.0, false, true);
        check(f64::NAN, f64::INFINITY, 8.0, false, false);
    }

    #[test]
    fn physical_feasibility_ignores_f2() {
        let check = |steady_n, crush_n, feasible| {
            let load = Load {
                needed_n: 1.0,
                steady_n,
                gripped_n: steady_n,
                crush_n,
                hand_max_n: 8.0,
                f2_n: 0.7,
            };
            assert_eq!(load.is_physically_feasible(), feasible, "{load:?}");
        };
        check(1.47, 1.5, true);
        check(1.5, 1.5, false);
        check(7.9, f64::INFINITY, true);
        check(8.0, f64::INFINITY, false);
        check(f64::NAN, f64::INFINITY, false);
    }

    #[test]
    fn off_centre_grasp_needs_more_force() {
        let scene = Scene::grasp(Object::built_in("wood").expect("built in"), HandSide::Right);
        let (reported, mut placed) = (
            scene.grasp_hint(0).expect("an object"),
            scene.objects[0].clone(),
        );
        let load = Load::from_object(&placed.object, &settings::Grasp::default(), 1);
        let along = [reported.yaw_rad.cos(), reported.yaw_rad.sin()];
        let mut gripped_n = |by_m: f64, [x, y]: [f64; 2]| {
            placed.position_m = [reported.from_m[0] + by_m * x, reported.from_m[1] + by_m * y];
            load.with_position_error(&placed, reported).gripped_n
        };
        assert!((gripped_n(0.002, along) / load.needed_n - 1.0).abs() < 1e-6);
        let beside = gripped_n(0.002, [-along[1], along[0]]) / load.needed_n;
        assert!((1.05..1.3).contains(&beside), "{beside}");
    }

    #[test]
    fn f2_uses_true_stiffness() {
        let grasp = settings::Grasp::default();
        let f2_n = |name: &str| {
            let object = Object::built_in(name).expect("built in");
            Load::from_object(&object, &grasp, 1).f2_n
        };
        assert!((f2_n("wood") - 8.0).abs() < 1e-12, "rigid: the upper bound");
        assert!(
            (f2_n("paper-box") - 0.75).abs() < 1e-12,
            "0.5 mm × 1500 N/m"
        );
        assert!(
            (f2_n("sponge") - 0.7).abs() < 1e-12,
            "soft: the lower bound"
        );
    }

    /// Regression: a box held well by two fingertips per side was counted as infeasible.
    #[test]
    fn crush_force_doubles_with_two_fingertips_per_side() {
        let (grasp, object) = (
            settings::Grasp::default(),
            Object::built_in("filled-paper-box"),
        );
        let object = object.expect("built in");
        let [one, two] = [1, 2].map(|tips| Load::from_object(&object, &grasp, tips));
        assert!(!one.is_feasible() && two.is_feasible(), "{one:?} {two:?}");
        assert_eq!(
            (two.crush_n, two.needed_n),
            (2.0 * one.crush_n, one.needed_n)
        );
        assert_eq!(two.hand_max_n, one.hand_max_n);
    }
}
