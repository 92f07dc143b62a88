//! Motion of a mobile base, as seen in the robot's world.
//!
//! The world is described in the base frame. A driving base makes it an accelerated frame: the
//! floor moves, and every body gets inertial forces (Euler, Coriolis, centrifugal, linear).
//! Approximations: the robot's links get no inertial forces, because their servos compensate them
//! like gravity. The gyroscopic moment between body spin and base turn is neglected. The base
//! heaves over bumps but neither tilts nor rises.

use nalgebra::Vector3;

use crate::range::{OutOfRange, in_range};

/// Highest speed of any base, m/s. Design choice: ten times that of a course base.
const SPEED_MAX_M_S: f64 = 5.0;
const ACCELERATION_MAX_M_S2: f64 = 50.0;
const TURN_MAX_RAD_S: f64 = 10.0;
const TURN_MAX_RAD_S2: f64 = 100.0;

/// Motion of the base: forward along x, turn about z, heave along z.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BaseMotion {
    /// Forward speed, m/s.
    pub speed_m_s: f64,
    /// Forward acceleration, m/s².
    pub acceleration_m_s2: f64,
    /// Yaw rate, rad/s, positive to the left.
    pub turn_rad_s: f64,
    /// Yaw acceleration, rad/s².
    pub turn_rad_s2: f64,
    /// Upward acceleration, m/s².
    pub heave_m_s2: f64,
}

/// Reason why a base motion is rejected.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum BaseMotionError {
    /// Value beyond the limits of a base.
    #[error(transparent)]
    OutOfRange(#[from] OutOfRange),
    /// An external engine simulates the world.
    #[error(
        "base motion rejected: the external engine has no moving base; simulate with the built-in \
         engine"
    )]
    ExternalEngine,
}

impl BaseMotion {
    /// Base at rest.
    pub const STILL: Self = Self {
        speed_m_s: 0.0,
        acceleration_m_s2: 0.0,
        turn_rad_s: 0.0,
        turn_rad_s2: 0.0,
        heave_m_s2: 0.0,
    };

    /// Rejects values beyond the limits of any base.
    pub(crate) fn check(&self) -> Result<(), OutOfRange> {
        for (what, value, most) in [
            (
                "the base's speed in metres per second",
                self.speed_m_s,
                SPEED_MAX_M_S,
            ),
            (
                "the base's acceleration in metres per second squared",
                self.acceleration_m_s2,
                ACCELERATION_MAX_M_S2,
            ),
            (
                "the base's yaw rate in radians per second",
                self.turn_rad_s,
                TURN_MAX_RAD_S,
            ),
            (
                "the base's yaw acceleration in radians per second squared",
                self.turn_rad_s2,
                TURN_MAX_RAD_S2,
            ),
            (
                "the base's heave in metres per second squared",
                self.heave_m_s2,
                ACCELERATION_MAX_M_S2,
            ),
        ] {
            in_range(what, value, -most, most)?;
        }
        Ok(())
    }

    /// Returns true if any component is not zero.
    pub(crate) fn is_moving(&self) -> bool {
        *self != Self::STILL
    }

    /// Integrates speed and yaw rate over `dt_s`.
    pub(crate) fn integrate(&mut self, dt_s: f64) {
        self.speed_m_s += self.acceleration_m_s2 * dt_s;
        self.turn_rad_s += self.turn_rad_s2 * dt_s;
    }

    /// Returns the velocity of the floor below a point, base frame, m/s.
    pub(crate) fn floor_velocity_m_s(&self, point_m: &Vector3<f64>) -> Vector3<f64> {
        Vector3::new(
            self.turn_rad_s * point_m.y - self.speed_m_s,
            -self.turn_rad_s * point_m.x,
            0.0,
        )
    }

    /// Returns the inertial acceleration of a body at a position and velocity, base frame, m/s².
    pub(crate) fn inertial_m_s2(
        &self,
        place_m: &Vector3<f64>,
        velocity_m_s: &Vector3<f64>,
    ) -> Vector3<f64> {
        let (turn, turn_sq) = (self.turn_rad_s, self.turn_rad_s * self.turn_rad_s);
        Vector3::new(
            turn_sq * place_m.x + self.turn_rad_s2 * place_m.y + 2.0 * turn * velocity_m_s.y
                - self.acceleration_m_s2,
            turn_sq * place_m.y
                - self.turn_rad_s2 * place_m.x
                - 2.0 * turn * velocity_m_s.x
                - self.speed_m_s * turn,
            -self.heave_m_s2,
        )
    }

    /// Returns the inertial angular acceleration of a body, base frame, rad/s².
    pub(crate) fn inertial_rad_s2(&self, angular_rad_s: &Vector3<f64>) -> Vector3<f64> {
        Vector3::new(
            self.turn_rad_s * angular_rad_s.y,
            -self.turn_rad_s * angular_rad_s.x,
            -self.turn_rad_s2,
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// In the base frame, a point at rest on the field moves like the floor.
    #[test]
    fn point_at_rest_moves_with_the_floor() {
        const DT_S: f64 = 1e-4;
        let mut ride = BaseMotion {
            speed_m_s: 0.2,
            acceleration_m_s2: 0.3,
            turn_rad_s: 0.5,
            turn_rad_s2: -0.4,
            heave_m_s2: 0.0,
        };
        let mut place_m = Vector3::new(0.7, -0.3, 0.0);
        let mut velocity_m_s = ride.floor_velocity_m_s(&place_m);
        for _ in 0..20_000 {
            velocity_m_s += ride.inertial_m_s2(&place_m, &velocity_m_s) * DT_S;
            place_m += velocity_m_s * DT_S;
            ride.integrate(DT_S);
        }
        let off_m_s = (velocity_m_s - ride.floor_velocity_m_s(&place_m)).norm();
        assert!(off_m_s < 1e-3, "{off_m_s} m/s after two seconds");
    }

    #[test]
    fn check_rejects_impossible_motion() {
        let spoil: [fn(&mut BaseMotion, f64); 5] = [
            |ride, value| ride.speed_m_s = value,
            |ride, value| ride.acceleration_m_s2 = value,
            |ride, value| ride.turn_rad_s = value,
            |ride, value| ride.turn_rad_s2 = value,
            |ride, value| ride.heave_m_s2 = value,
        ];
        for (index, spoil) in spoil.into_iter().enumerate() {
            for value in [f64::NAN, f64::INFINITY, -1e3, 1e3] {
                let mut ride = BaseMotion::STILL;
                spoil(&mut ride, value);
                assert!(ride.check().is_err(), "number {index} = {value}");
            }
        }
        assert!(BaseMotion::STILL.check().is_ok());
    }
}
