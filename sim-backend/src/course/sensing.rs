//! Sensors of a base: three IR and two photo sensors, as on the swarm's field.
//!
//! An IR sensor is a segment from the base's centre that detects discs and walls. A photo sensor
//! detects lights in a half-plane. Both photo sensors sit in front of the working hand: a light
//! that both detect is in front of it.

use core::f64::consts::{FRAC_1_SQRT_2, PI};

use super::base::PlanarPose;
use super::layout::HALF_SIDE_M;

/// Range of an IR sensor from the base's centre, m.
const IR_M: f64 = 1.0;
/// Range of a photo sensor, m.
const LIGHT_M: f64 = 4.0;
/// Photo sensors, metres ahead and to the left: in front of the right hand.
pub const PHOTO_SENSORS_M: [f64; 2] = [0.0, -0.12];
/// Angle of a photo sensor to straight ahead, rad. Design choice: the common field of view is 0.17
/// m wide where the hand's reach begins, slightly less than the reach. With the 12 steps of preset
/// R3 (0.34 m), a base at its edge passes the light and circles it forever.
const PHOTO_RAD: f64 = 14.0 * 2.0 * PI / 64.0;

#[derive(Clone, Copy, Debug)]
pub(super) struct Disc {
    pub(super) position_m: [f64; 2],
    pub(super) radius_m: f64,
}

/// Table row of the sensors: IR left 1, front 2, right 4, photo left 8, right 16, as in
/// [`field::Responses`].
pub(super) fn row(
    from: &PlanarPose,
    discs: impl Iterator<Item = Disc>,
    light_m: Option<[f64; 2]>,
) -> u8 {
    let mut ir = detects_wall(from);
    for disc in discs {
        let seen = detects_disc(from, &disc);
        ir = [0, 1, 2].map(|k| ir[k] || seen[k]);
    }
    let photo = light_m.map_or([false; 2], |light_m| detects_light(from, light_m));
    let bits = [ir[0], ir[1], ir[2], photo[0], photo[1]];
    (0..).zip(bits).map(|(k, bit)| u8::from(bit) << k).sum()
}

/// A point in the frames of the left (45°), front and right IR sensor.
fn in_ir_frames([ahead_m, left_m]: [f64; 2]) -> [[f64; 2]; 3] {
    let half = FRAC_1_SQRT_2;
    [
        [(ahead_m + left_m) * half, (left_m - ahead_m) * half],
        [ahead_m, left_m],
        [(ahead_m - left_m) * half, (left_m + ahead_m) * half],
    ]
}

fn detects_disc(from: &PlanarPose, disc: &Disc) -> [bool; 3] {
    in_ir_frames(from.relative_m(disc.position_m)).map(|[along_m, beside_m]| {
        let beyond_m = (along_m - IR_M).max(0.0);
        let off_sq = beyond_m * beyond_m + beside_m * beside_m;
        along_m > 0.0 && off_sq < disc.radius_m * disc.radius_m
    })
}

fn detects_wall(from: &PlanarPose) -> [bool; 3] {
    let half = FRAC_1_SQRT_2;
    [[half, half], [1.0, 0.0], [half, -half]].map(|[ahead, left]| {
        let tip_m = from.point_m([ahead * IR_M, left * IR_M]);
        tip_m.iter().any(|m| m.abs() > HALF_SIDE_M)
    })
}

fn detects_light(from: &PlanarPose, light_m: [f64; 2]) -> [bool; 2] {
    let [ahead_m, left_m] = from.relative_m(light_m);
    let (ahead_m, left_m) = (ahead_m - PHOTO_SENSORS_M[0], left_m - PHOTO_SENSORS_M[1]);
    let near = ahead_m * ahead_m + left_m * left_m < LIGHT_M * LIGHT_M;
    let (sin, cos) = libm::sincos(PHOTO_RAD);
    [
        near && ahead_m * cos + left_m * sin > 0.0,
        near && ahead_m * cos - left_m * sin > 0.0,
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check(at_m: [f64; 2], yaw_rad: f64, disc_m: [f64; 2], light_m: [f64; 2], expected: u8) {
        let from = PlanarPose {
            position_m: at_m,
            yaw_rad,
        };
        let disc = Disc {
            position_m: disc_m,
            radius_m: 0.2,
        };
        let row = row(&from, [disc].into_iter(), Some(light_m));
        assert_eq!(
            row, expected,
            "from {at_m:?} {yaw_rad}: disc {disc_m:?}, light {light_m:?}"
        );
    }

    #[test]
    fn row_bits_match_sensor_directions() {
        let (far, none) = ([-2.5, -2.5], [9.0, 9.0]);
        check([0.0, 0.0], 0.0, far, none, 0);
        check([0.0, 0.0], 0.0, [1.1, 0.0], none, 2);
        check([0.0, 0.0], 0.0, [1.3, 0.0], none, 0);
        check([0.0, 0.0], 0.0, [0.7, 0.7], none, 1);
        check([0.0, 0.0], 0.0, [0.7, -0.7], none, 4);
        check([0.0, 0.0], PI, [0.7, -0.7], none, 0);
        // Walls, ahead and in a corner.
        check([2.1, 0.0], 0.0, far, none, 2);
        check([2.5, 2.5], 0.0, far, none, 7);
        // Lights: ahead of the sensors, left, right, behind, too far.
        check([0.0, 0.0], 0.0, far, [1.0, -0.12], 24);
        check([0.0, 0.0], 0.0, far, [0.0, 1.0], 8);
        check([0.0, 0.0], 0.0, far, [0.0, -1.0], 16);
        check([0.0, 0.0], 0.0, far, [-1.0, -0.12], 0);
        check([0.0, 0.0], 0.0, far, [4.1, 0.0], 0);
    }
}
