//! How a robot's base moves, as its world sees it.
//!
//! The world is described in the base's frame, which a driving base makes an accelerated one: the floor moves by below it,
//! and every body feels inertial forces (Euler, Coriolis and centrifugal ones, and those of the origin's acceleration).
//! Approximations: the robot's own links feel nothing of it, because their servos hold them as they compensate gravity; the
//! gyroscopic moment of a body's spin together with the base's turn is left out; a base heaves over bumps, and neither
//! tilts nor rises.

use nalgebra::Vector3;

use crate::range::{OutOfRange, in_range};

/// The fastest that any base may be said to move. Ours: ten times what a base of a course does.
const SPEED_MAX_M_S: f64 = 5.0;
const ACCELERATION_MAX_M_S2: f64 = 50.0;
const TURN_MAX_RAD_S: f64 = 10.0;
const TURN_MAX_RAD_S2: f64 = 100.0;

/// A motion of the base: forward along its x axis, turning about z, heaving along z.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Ride {
    /// Speed forward, m/s.
    pub speed_m_s: f64,
    /// Its change, m/s².
    pub acceleration_m_s2: f64,
    /// Turning, rad/s, positive to the left.
    pub turn_rad_s: f64,
    /// Its change, rad/s².
    pub turn_rad_s2: f64,
    /// Acceleration upwards, m/s².
    pub heave_m_s2: f64,
}

impl Ride {
    /// A base that stands.
    pub const STILL: Self = Self {
        speed_m_s: 0.0,
        acceleration_m_s2: 0.0,
        turn_rad_s: 0.0,
        turn_rad_s2: 0.0,
        heave_m_s2: 0.0,
    };

    /// Refuses what no base does.
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
                "the base's turning in radians per second",
                self.turn_rad_s,
                TURN_MAX_RAD_S,
            ),
            (
                "the change of the base's turning in radians per second squared",
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

    /// Whether anything moves.
    pub(crate) fn moves(&self) -> bool {
        *self != Self::STILL
    }

    /// Lets time pass: speeds go on as their changes say.
    pub(crate) fn go_on(&mut self, dt_s: f64) {
        self.speed_m_s += self.acceleration_m_s2 * dt_s;
        self.turn_rad_s += self.turn_rad_s2 * dt_s;
    }

    /// Velocity of the floor below a point, base frame, m/s.
    pub(crate) fn floor_m_s(&self, point_m: &Vector3<f64>) -> Vector3<f64> {
        Vector3::new(
            self.turn_rad_s * point_m.y - self.speed_m_s,
            -self.turn_rad_s * point_m.x,
            0.0,
        )
    }

    /// Acceleration that a body at a place with a velocity, both of the base frame, is given by the frame, m/s².
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

    /// The same of its turning, whose velocity is that of the base frame, rad/s².
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

    /// A point at rest in the field, seen from a base that drives and turns, moves as the floor does.
    #[test]
    fn what_rests_in_the_field_moves_with_the_floor() {
        const DT_S: f64 = 1e-4;
        let mut ride = Ride {
            speed_m_s: 0.2,
            acceleration_m_s2: 0.3,
            turn_rad_s: 0.5,
            turn_rad_s2: -0.4,
            heave_m_s2: 0.0,
        };
        let mut place_m = Vector3::new(0.7, -0.3, 0.0);
        let mut velocity_m_s = ride.floor_m_s(&place_m);
        for _ in 0..20_000 {
            velocity_m_s += ride.inertial_m_s2(&place_m, &velocity_m_s) * DT_S;
            place_m += velocity_m_s * DT_S;
            ride.go_on(DT_S);
        }
        let off_m_s = (velocity_m_s - ride.floor_m_s(&place_m)).norm();
        assert!(off_m_s < 1e-3, "{off_m_s} m/s after two seconds");
    }

    #[test]
    fn what_no_base_does_is_refused() {
        let spoil: [fn(&mut Ride, f64); 5] = [
            |ride, value| ride.speed_m_s = value,
            |ride, value| ride.acceleration_m_s2 = value,
            |ride, value| ride.turn_rad_s = value,
            |ride, value| ride.turn_rad_s2 = value,
            |ride, value| ride.heave_m_s2 = value,
        ];
        for (index, spoil) in spoil.into_iter().enumerate() {
            for value in [f64::NAN, f64::INFINITY, -1e3, 1e3] {
                let mut ride = Ride::STILL;
                spoil(&mut ride, value);
                assert!(ride.check().is_err(), "number {index} = {value}");
            }
        }
        assert!(Ride::STILL.check().is_ok());
    }
}
