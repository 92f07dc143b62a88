//! What a hand is asked to do: tip positions and directions, usually built from a grasp around an object's centre.

use core::f64::consts::{FRAC_PI_2, PI};

use nalgebra::Vector3;

use crate::model::HandModel;
use crate::sizes::FINGERS;

/// Target of the inverse kinematics of one hand, base frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HandTarget {
    /// Centre of each dome's sphere, metres: met exactly where reachable.
    pub tip_m: [Vector3<f64>; FINGERS],
    /// Wanted dome axes, unit length: second in rank.
    pub dome_axis: [Vector3<f64>; FINGERS],
    /// Wanted pointing direction of the hand, unit length: third in rank.
    pub hand_axis: Vector3<f64>,
    /// Wanted angle of both finger roots, radians (0: fingers in line with the hand; in phase they tilt like a wrist).
    pub root_rad: f64,
}

impl HandTarget {
    /// Whether every number is finite; the inverse kinematics refuses a target that is not.
    #[must_use]
    pub fn is_finite(&self) -> bool {
        let vectors = self
            .tip_m
            .iter()
            .chain(&self.dome_axis)
            .chain([&self.hand_axis]);
        self.root_rad.is_finite() && vectors.flatten().all(|value| value.is_finite())
    }
}

/// A two-finger grasp around a point: the vocabulary in which tasks speak about a hand.
///
/// The closing axis n is horizontal and points from finger 2's side to finger 1's side; t is n turned 90° anticlockwise
/// seen from above; z is up. Finger 1 presses along −n, finger 2 along +n.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct GraspFrame {
    /// Point between the fingertips, base frame, metres.
    pub centre_m: Vector3<f64>,
    /// Direction of n in the horizontal plane, radians from the base's x.
    pub closing_yaw_rad: f64,
    /// Direction of the hand's pointing axis in the horizontal plane, radians; without effect when pointing straight down.
    pub hand_azimuth_rad: f64,
    /// Angle of the hand's pointing axis below the horizontal, radians; π/2 points straight down.
    pub hand_pitch_rad: f64,
    /// Wanted angle of both finger roots, radians.
    pub root_rad: f64,
    /// Distance of each dome's surface (its pole) from the centre along the closing axis, metres; negative presses in.
    pub half_opening_m: [f64; FINGERS],
    /// Offset of each tip along t, metres. `[d, -d]` turns a held cap anticlockwise seen from above for d > 0.
    pub tangential_m: [f64; FINGERS],
    /// Offset of each tip along z, metres: feed-forward against sag.
    pub up_m: [f64; FINGERS],
}

impl GraspFrame {
    /// A grasp from straight above, both domes `opening_m / 2` from the centre.
    #[must_use]
    pub fn from_above(centre_m: Vector3<f64>, closing_yaw_rad: f64, opening_m: f64) -> GraspFrame {
        GraspFrame {
            centre_m,
            closing_yaw_rad,
            hand_azimuth_rad: 0.0,
            hand_pitch_rad: FRAC_PI_2,
            root_rad: 0.0,
            half_opening_m: [opening_m / 2.0; FINGERS],
            tangential_m: [0.0; FINGERS],
            up_m: [0.0; FINGERS],
        }
    }

    /// The closing axis n, unit length, from finger 2's side to finger 1's side.
    #[must_use]
    pub fn closing_axis(&self) -> Vector3<f64> {
        let (sin, cos) = libm::sincos(self.closing_yaw_rad);
        Vector3::new(cos, sin, 0.0)
    }

    /// The tips, dome axes and hand axis that this grasp asks of `hand`; the dome radius is added here.
    #[must_use]
    pub fn target(&self, hand: &HandModel) -> HandTarget {
        let n = self.closing_axis();
        let t = Vector3::new(-n.y, n.x, 0.0);
        let tip = |finger: usize, outward: Vector3<f64>| {
            self.centre_m
                + outward * (self.half_opening_m[finger] + hand.dome_radius_m[finger])
                + t * self.tangential_m[finger]
                + Vector3::z() * self.up_m[finger]
        };
        HandTarget {
            tip_m: [tip(0, n), tip(1, -n)],
            dome_axis: [-n, n],
            hand_axis: self.hand_axis(),
            root_rad: self.root_rad,
        }
    }

    fn hand_axis(&self) -> Vector3<f64> {
        let (azimuth_sin, azimuth_cos) = libm::sincos(self.hand_azimuth_rad);
        let (pitch_sin, pitch_cos) = libm::sincos(self.hand_pitch_rad);
        Vector3::new(pitch_cos * azimuth_cos, pitch_cos * azimuth_sin, -pitch_sin)
    }
}

impl HandModel {
    /// Direction from the shoulder to a point in the horizontal plane, radians: with the arm's joints in one vertical
    /// plane this is the shoulder yaw that brings the hand over the point.
    #[must_use]
    pub fn bearing_rad(&self, point_m: &Vector3<f64>) -> f64 {
        let from_shoulder = point_m - self.shoulder_m();
        libm::atan2(from_shoulder.y, from_shoulder.x)
    }

    /// Wrist roll that gives a hand over `centre_m` the closing yaw: bearing + 90° − yaw for a hand pointing down,
    /// brought into (−180°, 180°].
    pub(crate) fn wrist_roll_rad(&self, centre_m: &Vector3<f64>, closing_yaw_rad: f64) -> f64 {
        let turns = self.bearing_rad(centre_m) + FRAC_PI_2 - closing_yaw_rad;
        turns - 2.0 * PI * libm::round(turns / (2.0 * PI))
    }

    /// Of the two closing yaws that hold an object the same way (fingers exchanged: yaw and yaw + 180°), the one that
    /// keeps the wrist roll within ±90°, radians. For a move, pass the centre at mid-path: the choice then holds from
    /// start to end.
    #[must_use]
    pub fn closing_yaw_rad(&self, centre_m: &Vector3<f64>, closing_yaw_rad: f64) -> f64 {
        let roll = self.wrist_roll_rad(centre_m, closing_yaw_rad);
        if libm::fabs(roll) <= FRAC_PI_2 {
            closing_yaw_rad
        } else {
            closing_yaw_rad + PI
        }
    }
}
