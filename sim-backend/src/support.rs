//! Supports of bodies: the table, plates on it, and the rim of a bottle's neck.
//!
//! All supports are level. A corner of a body stands on the highest support that it has not sunk
//! below; a body next to a plate therefore does not stand on it. Fingertips have no contact with
//! supports. For a mobile base the table is the floor and moves relative to the base; plates move
//! with the base.

use nalgebra::Vector3;

use crate::base_motion::BaseMotion;
use crate::contact::Wrench;

/// Depth below a plate or rim from which a corner is next to it, m. Design choice: standing corners
/// sink by less than a tenth.
const SUNK_MAX_M: f64 = 0.005;

/// Level, axis-parallel plate on the table, such as a stand or a place of unexpected height.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plate {
    /// Middle: x, y, base frame, m.
    pub centre_m: [f64; 2],
    /// Half edges along x and y, m.
    pub half_m: [f64; 2],
    /// Height of the top above the table, m.
    pub height_m: f64,
}

/// Top of a bottle's neck: a level disc that may move.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Rim {
    pub(crate) centre_m: Vector3<f64>,
    pub(crate) radius_m: f64,
    pub(crate) velocity_m_s: Vector3<f64>,
}

#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Ground<'a> {
    pub(crate) plates: &'a [Plate],
    pub(crate) rim: Option<Rim>,
    pub(crate) ride: BaseMotion,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Support {
    pub(crate) height_m: f64,
    pub(crate) velocity_m_s: Vector3<f64>,
    pub(crate) is_rim: bool,
}

/// Load of a body on the rim: force, and moment about the rim's centre, base frame.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct RimLoad(pub(crate) Wrench);

impl Plate {
    fn covers(&self, point_m: &Vector3<f64>) -> bool {
        (point_m.x - self.centre_m[0]).abs() <= self.half_m[0]
            && (point_m.y - self.centre_m[1]).abs() <= self.half_m[1]
            && point_m.z > self.height_m - SUNK_MAX_M
    }
}

impl Rim {
    fn covers(&self, point_m: &Vector3<f64>) -> bool {
        let from_m = point_m - self.centre_m;
        from_m.x * from_m.x + from_m.y * from_m.y <= self.radius_m * self.radius_m
            && from_m.z > -SUNK_MAX_M
    }
}

impl Ground<'_> {
    pub(crate) fn under(&self, point_m: &Vector3<f64>) -> Support {
        let plates = self.plates.iter().filter(|plate| plate.covers(point_m));
        let height_m = plates.fold(0.0_f64, |high, plate| high.max(plate.height_m));
        let rim = self
            .rim
            .filter(|rim| rim.covers(point_m) && rim.centre_m.z > height_m);
        Support {
            height_m: rim.map_or(height_m, |rim| rim.centre_m.z),
            velocity_m_s: match rim {
                Some(rim) => rim.velocity_m_s,
                None if height_m > 0.0 || !self.ride.is_moving() => Vector3::zeros(),
                None => self.ride.floor_velocity_m_s(point_m),
            },
            is_rim: rim.is_some(),
        }
    }

    pub(crate) fn highest_m(&self) -> f64 {
        let plates_m = self
            .plates
            .iter()
            .fold(0.0_f64, |high, plate| high.max(plate.height_m));
        self.rim
            .map_or(plates_m, |rim| plates_m.max(rim.centre_m.z))
    }
}

impl RimLoad {
    /// Adds the reaction to a support force that acts on the body at a point.
    pub(crate) fn add_reaction(
        &mut self,
        rim: &Rim,
        point_m: &Vector3<f64>,
        on_body_n: &Vector3<f64>,
    ) {
        self.0.force_n -= on_body_n;
        self.0.moment_n_m -= (point_m - rim.centre_m).cross(on_body_n);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PLATE: Plate = Plate {
        centre_m: [0.3, 0.1],
        half_m: [0.02, 0.03],
        height_m: 0.01,
    };

    #[test]
    fn corner_stands_on_the_highest_reached_support() {
        let rim = Rim {
            centre_m: Vector3::new(0.3, 0.1, 0.12),
            radius_m: 0.015,
            velocity_m_s: Vector3::new(0.0, 0.0, 0.1),
        };
        let check = |at_m: [f64; 3], with_rim: bool, expected_m: f64| {
            let ground = Ground {
                plates: &[PLATE],
                rim: with_rim.then_some(rim),
                ride: BaseMotion::STILL,
            };
            let support = ground.under(&Vector3::from(at_m));
            assert_eq!(support.height_m, expected_m, "{at_m:?}");
            assert_eq!(support.is_rim, expected_m == 0.12);
        };
        check([0.3, 0.1, 0.2], false, 0.01);
        check([0.3, 0.1, 0.0099], false, 0.01);
        check([0.3, 0.1, 0.004], false, 0.0);
        check([0.321, 0.1, 0.2], false, 0.0);
        check([0.3, 0.131, 0.2], false, 0.0);
        check([0.3, 0.114, 0.1199], true, 0.12);
        check([0.3, 0.116, 0.1199], true, 0.01);
        check([0.3, 0.1, 0.1], true, 0.01);
    }
}
