//! Floor under a base: random bumps along its path.
//!
//! Bumps depend on the distance driven, not on the position, so that any route meets the same
//! bumps. Profile: H·sin⁴(π·s / L), with zero curvature at both ends.

use core::f64::consts::PI;

use crate::random::Random;
use crate::scene::stream;

/// Ranges of spacing, length and height of bumps, m.
const BETWEEN_M: [f64; 2] = [0.3, 0.8];
const LENGTH_M: [f64; 2] = [0.06, 0.12];
const HEIGHT_M: [f64; 2] = [0.001, 0.004];

/// Floor along a base's path.
#[derive(Clone, Debug)]
pub struct Floor {
    random: Option<Random>,
    /// Distance to the next bump, m; negative on the bump.
    ahead_m: f64,
    length_m: f64,
    height_m: f64,
}

impl Floor {
    /// Returns a floor without bumps.
    #[must_use]
    pub fn even() -> Self {
        Self {
            random: None,
            ahead_m: f64::INFINITY,
            length_m: 0.0,
            height_m: 0.0,
        }
    }

    /// Returns the floor of a robot.
    #[must_use]
    pub fn bumpy(seed: u64, robot: usize) -> Self {
        let mut floor = Self {
            random: Some(Random::new(seed, stream::FLOOR + robot as u64)),
            ..Self::even()
        };
        floor.draw();
        floor
    }

    fn draw(&mut self) {
        let Some(random) = &mut self.random else {
            return;
        };
        let mut draw = |[low, high]: [f64; 2]| random.between(low, high);
        self.ahead_m = draw(BETWEEN_M);
        self.length_m = draw(LENGTH_M);
        self.height_m = draw(HEIGHT_M);
    }

    /// Advances along the path; returns the vertical acceleration, m/s². Neglects speed changes.
    pub(super) fn heave_m_s2(&mut self, way_m: f64, speed_m_s: f64) -> f64 {
        self.ahead_m -= way_m;
        if self.ahead_m < -self.length_m {
            self.draw();
        }
        if self.ahead_m >= 0.0 {
            return 0.0;
        }
        let (sin, cos) = libm::sincos(PI * -self.ahead_m / self.length_m);
        let sin_sq = sin * sin;
        let curvature = 12.0 * sin_sq * cos * cos - 4.0 * sin_sq * sin_sq;
        let per_m = PI / self.length_m;
        self.height_m * per_m * per_m * curvature * speed_m_s * speed_m_s
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Doubly integrated heave equals the bump.
    #[test]
    fn integrated_heave_matches_the_bump_height() {
        let (speed_m_s, dt_s) = (0.3, 1e-5);
        let mut floor = Floor::bumpy(3, 0);
        let height_m = floor.height_m;
        let (mut rises_m_s, mut high_m, mut highest_m) = (0.0, 0.0, 0.0_f64);
        let way_m = floor.ahead_m + floor.length_m;
        for _ in 0..(way_m / speed_m_s / dt_s) as usize {
            rises_m_s += floor.heave_m_s2(speed_m_s * dt_s, speed_m_s) * dt_s;
            high_m += rises_m_s * dt_s;
            highest_m = highest_m.max(high_m);
        }
        assert!(
            (highest_m / height_m - 1.0).abs() < 0.01,
            "{highest_m} of {height_m} m"
        );
        assert!(
            high_m.abs() < 0.01 * height_m,
            "{high_m} m after {height_m} m"
        );
    }

    #[test]
    fn bumps_depend_on_seed_and_robot() {
        let drive = |mut floor: Floor| -> Vec<f64> {
            (0..2000).map(|_| floor.heave_m_s2(0.001, 0.3)).collect()
        };
        assert!(drive(Floor::even()).iter().all(|heave| *heave == 0.0));
        assert_eq!(drive(Floor::bumpy(5, 0)), drive(Floor::bumpy(5, 0)));
        assert_ne!(drive(Floor::bumpy(5, 0)), drive(Floor::bumpy(5, 1)));
        assert_ne!(drive(Floor::bumpy(5, 0)), drive(Floor::bumpy(6, 0)));
    }
}
