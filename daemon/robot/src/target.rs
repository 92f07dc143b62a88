//! What a hand is asked to do: tip positions and directions, usually built from a grasp around an object's centre.

use core::f64::consts::FRAC_PI_2;

use nalgebra::Vector3;

use crate::model::HandModel;
use crate::sizes::{FINGERS_MAX, VIRTUAL_FINGERS};

/// Distance from the axis of a turn at which a hand that turns by its wrist goes as far round as fingertips would go past each
/// other, metres (ours: the radius of a small cap; every turn the longer is one regrasp the fewer).
const WRIST_TURN_RADIUS_M: f64 = 0.012;

/// Target of the inverse kinematics of one hand, base frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HandTarget {
    /// Centre of each dome's sphere, metres: met exactly where reachable. Zero where the hand has no finger.
    pub tip_m: [Vector3<f64>; FINGERS_MAX],
    /// Wanted dome axes, unit length: second in rank. Zero where the hand has no finger.
    pub dome_axis: [Vector3<f64>; FINGERS_MAX],
    /// Wanted pointing direction of the hand, unit length: third in rank.
    pub hand_axis: Vector3<f64>,
    /// Wanted angle of all finger roots, radians (0: fingers in line with the hand; in phase they tilt like a wrist).
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

/// A grasp around a point by two opposing virtual fingers: the vocabulary in which tasks speak about a hand.
///
/// A virtual finger stands for the fingertips that press together from one side. The closing axis n is horizontal and points
/// from the second side to the first; t is n turned 90° anticlockwise seen from above; z is up. The first virtual finger
/// presses along −n, the second along +n.
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
    /// Wanted angle of all finger roots, radians.
    pub root_rad: f64,
    /// Distance of each side's dome surfaces (their poles) from the centre along the closing axis, metres; negative presses in.
    pub half_opening_m: [f64; VIRTUAL_FINGERS],
    /// Offset of each side's tips along t, metres. `[d, -d]` turns a held cap anticlockwise seen from above for d > 0; a hand
    /// whose fingertips cannot pass each other does it by its wrist, see [`GraspFrame::as_done_by`].
    pub tangential_m: [f64; VIRTUAL_FINGERS],
    /// Offset of each side's tips along z, metres: feed-forward against sag.
    pub up_m: [f64; VIRTUAL_FINGERS],
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
            half_opening_m: [opening_m / 2.0; VIRTUAL_FINGERS],
            tangential_m: [0.0; VIRTUAL_FINGERS],
            up_m: [0.0; VIRTUAL_FINGERS],
        }
    }

    /// The closing axis n, unit length, from finger 2's side to finger 1's side.
    #[must_use]
    pub fn closing_axis(&self) -> Vector3<f64> {
        let (sin, cos) = libm::sincos(self.closing_yaw_rad);
        Vector3::new(cos, sin, 0.0)
    }

    /// The grasp as `hand` does it: one whose fingertips cannot pass each other, but whose wrist turns it about the vertical, turns
    /// as a whole by `d / 12 mm` where its fingertips should pass each other by `[d, -d]`.
    #[must_use]
    pub fn as_done_by(&self, hand: &HandModel) -> GraspFrame {
        if !hand.turns_by_wrist {
            return *self;
        }
        let [first_m, second_m] = self.tangential_m;
        let turn_rad = (first_m - second_m) / 2.0 / WRIST_TURN_RADIUS_M;
        GraspFrame {
            closing_yaw_rad: self.closing_yaw_rad + turn_rad,
            tangential_m: [(first_m + second_m) / 2.0; VIRTUAL_FINGERS],
            ..*self
        }
    }

    /// The tips, dome axes and hand axis that this grasp asks of `hand`; the dome radius is added here.
    #[must_use]
    pub fn target(&self, hand: &HandModel) -> HandTarget {
        self.as_done_by(hand).target_of_tips(hand)
    }

    fn target_of_tips(&self, hand: &HandModel) -> HandTarget {
        let n = self.closing_axis();
        let t = Vector3::new(-n.y, n.x, 0.0);
        let hand_axis = self.hand_axis();
        let beside = n.cross(&hand_axis);
        let mut target = HandTarget {
            tip_m: [Vector3::zeros(); FINGERS_MAX],
            dome_axis: [Vector3::zeros(); FINGERS_MAX],
            hand_axis,
            root_rad: self.root_rad,
        };
        for (finger, model) in hand.fingers[..hand.finger_count].iter().enumerate() {
            let side = model.virtual_finger;
            let outward = if side == 0 { n } else { -n };
            target.tip_m[finger] = self.centre_m
                + outward * (self.half_opening_m[side] + hand.tip_radius_m[finger])
                + t * self.tangential_m[side]
                + Vector3::z() * self.up_m[side]
                + beside * model.beside_m;
            target.dome_axis[finger] = -outward;
        }
        target
    }

    fn hand_axis(&self) -> Vector3<f64> {
        let (azimuth_sin, azimuth_cos) = libm::sincos(self.hand_azimuth_rad);
        let (pitch_sin, pitch_cos) = libm::sincos(self.hand_pitch_rad);
        Vector3::new(pitch_cos * azimuth_cos, pitch_cos * azimuth_sin, -pitch_sin)
    }
}
