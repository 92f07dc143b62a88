//! Force of a disturbance on one object in one hand, and the grip force that it needs.

use super::case::{BUMP_S, Direction, Disturbance, RAMP_S};
use crate::held::HeldTrial;
use crate::judge::Load;

/// Gravity, m/s².
const GRAVITY_M_S2: f64 = 9.81;
/// Ratio of kinetic to static friction of both engines.
const KINETIC_SHARE: f64 = 0.9;

/// Disturbance of one object in one hand.
#[derive(Clone, Copy, Debug)]
pub(super) struct Applied {
    disturbance: Disturbance,
    weight_n: f64,
    friction: f64,
    closing: [f64; 3],
    unit: [f64; 3],
}

impl Applied {
    /// Returns the disturbance of a trial.
    pub(super) fn new(disturbance: Disturbance, trial: &HeldTrial<'_>, seed: u64) -> Self {
        let (yaw_rad, object) = (trial.closing_yaw_rad(), trial.object());
        Self {
            unit: match disturbance {
                Disturbance::Load(_, _, direction) => direction.unit(yaw_rad, seed),
                _ => [0.0; 3],
            },
            disturbance,
            weight_n: object.mass_kg * GRAVITY_M_S2,
            friction: object.friction,
            closing: Direction::Along.unit(yaw_rad, seed),
        }
    }

    /// Returns the force on the object at this time since the begin, N.
    pub(super) fn force_n(&self, since_s: f64) -> [f64; 3] {
        let load_n = match self.disturbance {
            Disturbance::Load(course, weights, _) => {
                weights * course.share(since_s) * self.weight_n
            }
            _ => 0.0,
        };
        self.unit.map(|unit| unit * load_n)
    }

    /// Returns the grip force per side that holds weight and load by friction, N.
    pub(super) fn needed_n(&self, since_s: f64) -> f64 {
        self.needed_with_n(self.force_n(since_s), 0.0)
    }

    /// Returns true if the hand could hold the object throughout: by friction, below the crush
    /// force and the hand's maximum.
    pub(super) fn is_allowed(&self, load: &Load) -> bool {
        let largest_n = self.largest_needed_n();
        largest_n < load.hand_max_n && largest_n < load.crush_n
    }

    /// Returns true if the hand could stop the object although it slides: by kinetic friction,
    /// below F_2. A load begins faster than a servo closes, so the object slides first.
    pub(super) fn is_catchable(&self, load: &Load) -> bool {
        self.is_allowed(load) && self.largest_needed_n() / KINETIC_SHARE < load.f2_n
    }

    /// Returns the largest grip force per side that the disturbance needs, N.
    fn largest_needed_n(&self) -> f64 {
        // Loads are largest at the begin (step, impulse) or at the end (ramp).
        let lifting_m_s2 = match self.disturbance {
            Disturbance::Bump(height_m) => {
                let omega_rad_s = core::f64::consts::TAU / BUMP_S;
                height_m / 2.0 * omega_rad_s * omega_rad_s
            }
            _ => 0.0,
        };
        let inertial_n = self.weight_n * lifting_m_s2 / GRAVITY_M_S2;
        [0.0, RAMP_S]
            .map(|since_s| self.needed_with_n(self.force_n(since_s), inertial_n))
            .into_iter()
            .fold(0.0, f64::max)
    }

    /// Two fingertips with Coulomb friction: together they carry the force across the closing axis,
    /// and the weaker one still presses under the force along it.
    fn needed_with_n(&self, force_n: [f64; 3], inertial_n: f64) -> f64 {
        let [x_n, y_n, z_n] = force_n;
        let total_n = [x_n, y_n, z_n - self.weight_n - inertial_n];
        let along_n: f64 = total_n
            .iter()
            .zip(self.closing)
            .map(|(n, axis)| n * axis)
            .sum();
        let square_n2: f64 = total_n.iter().map(|n| n * n).sum();
        let across_n = (square_n2 - along_n * along_n).max(0.0).sqrt();
        (across_n / (2.0 * self.friction)).max(along_n.abs() / 2.0)
    }
}

#[cfg(test)]
mod tests {
    use super::super::case::Course;
    use super::*;

    fn applied(disturbance: Disturbance, unit: [f64; 3]) -> Applied {
        Applied {
            disturbance,
            weight_n: 3.0,
            friction: 0.5,
            closing: [0.0, 1.0, 0.0],
            unit,
        }
    }

    #[test]
    fn loads_have_their_course_and_size() {
        let check = |course, since_s: f64, expected_n: f64| {
            let load = Disturbance::Load(course, 2.0, Direction::Down);
            let [x_n, y_n, z_n] = applied(load, [0.0, 0.0, -1.0]).force_n(since_s);
            assert_eq!((x_n, y_n), (0.0, 0.0));
            assert!((z_n + expected_n).abs() < 1e-12, "{course:?}: {z_n} N");
        };
        check(Course::Step, 0.0, 6.0);
        check(Course::Step, 4.0, 6.0);
        check(Course::Ramp, 0.5, 3.0);
        check(Course::Ramp, 4.0, 6.0);
        check(Course::Impulse, 0.0, 6.0);
        check(Course::Impulse, 0.05, 0.0);
    }

    #[test]
    fn sliding_object_needs_more_force() {
        let step = |weights| {
            applied(
                Disturbance::Load(Course::Step, weights, Direction::Down),
                [0.0, 0.0, -1.0],
            )
        };
        let load = Load {
            needed_n: 3.0,
            gripped_n: 3.0,
            steady_n: 3.0,
            crush_n: f64::INFINITY,
            f2_n: 8.0,
            hand_max_n: 8.0,
        };
        for (weights, allowed, catchable) in
            [(1.0, true, true), (1.5, true, false), (2.0, false, false)]
        {
            let step = step(weights);
            let verdicts = (step.is_allowed(&load), step.is_catchable(&load));
            assert_eq!(verdicts, (allowed, catchable), "{weights} × weight");
        }
    }

    #[test]
    fn needed_force_depends_on_the_direction() {
        let load = Disturbance::Load(Course::Step, 1.0, Direction::Any);
        let needed_n = |unit| applied(load, unit).needed_n(0.0);
        for (unit, expected_n) in [
            ([0.0, 0.0, -1.0], 6.0),
            ([0.0, 0.0, 1.0], 0.0),
            ([1.0, 0.0, 0.0], 18.0_f64.sqrt()),
            ([0.0, 1.0, 0.0], 3.0),
        ] {
            let needed_n = needed_n(unit);
            assert!(
                (needed_n - expected_n).abs() < 1e-12,
                "{unit:?}: {needed_n} N"
            );
        }
    }
}
