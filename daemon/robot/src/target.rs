//! Target of a hand: tip positions and directions, usually from a grasp pose.

use crate::forward::HandPose;
use crate::grasp_sides::PerSide;
use core::f64::consts::FRAC_PI_2;

use nalgebra::Vector3;

use crate::model::HandModel;
use crate::sizes::FINGERTIPS_MAX;

/// Radius of a turn at which a wrist rotation replaces the passing of fingertips, metres. Design
/// choice: the radius of a small cap. Longer turns need fewer regrasps.
const WRIST_TURN_RADIUS_M: f64 = 0.012;
/// Smallest product of distances beside and across, m³, that gives a direction: rounding.
const BESIDE_ACROSS_MIN_M3: f64 = 1e-12;

impl HandModel {
    /// Returns the radius at which the wrist executes opposite tangential offsets of the sides,
    /// metres; `None` if the fingers do ([`GraspPose::executed_by`]).
    #[must_use]
    pub fn wrist_turn_radius_m(&self) -> Option<f64> {
        self.turns_by_wrist.then_some(WRIST_TURN_RADIUS_M)
    }

    /// Returns the hand axis of the grasp pose whose fingertips lie beside each other as in this
    /// posture, unit length; `None` if no grasp side has several fingertips. The hand itself may
    /// point elsewhere, because its direction has a lower priority than the tips.
    #[must_use]
    pub fn hand_axis_of_tips(&self, pose: &HandPose) -> Option<Vector3<f64>> {
        let fingers = self.fingers[..self.finger_count].iter().enumerate();
        let beside = fingers.fold(Vector3::zeros(), |sum: Vector3<f64>, (finger, model)| {
            let from_middle_m = pose.tip_m(finger) - pose.side_m(model.side);
            sum + from_middle_m * model.offset_m
        });
        let across_m = pose.across_m();
        let closing = Vector3::new(across_m.x, across_m.y, 0.0);
        // Inverts `beside = n × axis`.
        beside.cross(&closing).try_normalize(BESIDE_ACROSS_MIN_M3)
    }
}

/// Target of the inverse kinematics of one hand, base frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HandTarget {
    /// Centre of each dome's sphere, metres: first priority. Zero where the hand has no finger.
    pub tip_m: [Vector3<f64>; FINGERTIPS_MAX],
    /// Target dome axes, unit length: second priority. Zero where the hand has no finger.
    pub dome_axis: [Vector3<f64>; FINGERTIPS_MAX],
    /// Target pointing direction of the hand, unit length: third priority.
    pub hand_axis: Vector3<f64>,
    /// Target angle of all finger roots, radians (0: fingers in line with the hand; in phase they
    /// tilt like a wrist).
    pub root_rad: f64,
}

impl HandTarget {
    /// Returns true if every number is finite. The inverse kinematics rejects other targets.
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

/// Grasp pose: two opposing grasp sides around a point.
///
/// A grasp side stands for the fingertips that press together. The closing axis n is horizontal and
/// points from the second side to the first; t is n turned 90° anticlockwise seen from above; z is
/// up. The first side presses along −n, the second along +n.
///
/// ```
/// use nalgebra::Vector3;
/// use robot_model::GraspPose;
///
/// // A grasp of a 50 mm object; the hand closes along y.
/// let grasp = GraspPose::from_above(Vector3::new(0.3, 0.0, 0.05), std::f64::consts::FRAC_PI_2, 0.05);
/// assert!((grasp.closing_axis() - Vector3::y()).norm() < 1e-12);
/// assert_eq!(grasp.half_opening_m, [0.025; 2].into());
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct GraspPose {
    /// Point between the fingertips, base frame, metres.
    pub centre_m: Vector3<f64>,
    /// Direction of n in the horizontal plane, radians from the base's x.
    pub closing_yaw_rad: f64,
    /// Direction of the hand's pointing axis in the horizontal plane, radians; without effect when
    /// pointing straight down.
    pub hand_azimuth_rad: f64,
    /// Angle of the hand's pointing axis below the horizontal, radians; π/2 points straight down.
    pub hand_pitch_rad: f64,
    /// Target angle of all finger roots, radians.
    pub root_rad: f64,
    /// Distance of each side's dome surfaces (their poles) from the centre along the closing axis,
    /// metres; negative presses in.
    pub half_opening_m: PerSide<f64>,
    /// Offset of each side's tips along t, metres. `[d, -d]` turns a held cap anticlockwise seen
    /// from above for d > 0. If the fingertips of a hand cannot pass each other, its wrist turns
    /// instead; see [`GraspPose::executed_by`].
    pub tangential_m: PerSide<f64>,
    /// Offset of each side's tips along z, metres: feed-forward against sag.
    pub up_m: PerSide<f64>,
}

impl GraspPose {
    /// Creates a grasp from above; both domes are `opening_m / 2` from the centre.
    #[must_use]
    pub fn from_above(centre_m: Vector3<f64>, closing_yaw_rad: f64, opening_m: f64) -> GraspPose {
        GraspPose {
            centre_m,
            closing_yaw_rad,
            hand_azimuth_rad: 0.0,
            hand_pitch_rad: FRAC_PI_2,
            root_rad: 0.0,
            half_opening_m: PerSide::repeat(opening_m / 2.0),
            tangential_m: PerSide::repeat(0.0),
            up_m: PerSide::repeat(0.0),
        }
    }

    /// Returns the closing axis n, unit length, from the second to the first side.
    #[must_use]
    pub fn closing_axis(&self) -> Vector3<f64> {
        let (sin, cos) = libm::sincos(self.closing_yaw_rad);
        Vector3::new(cos, sin, 0.0)
    }

    /// Returns the grasp as `hand` executes it. If its fingertips cannot pass each other but its
    /// wrist turns about the vertical, the hand turns as a whole by `d / 12 mm` in place of the
    /// tangential offsets `[d, -d]`.
    #[must_use]
    pub fn executed_by(&self, hand: &HandModel) -> GraspPose {
        let Some(radius_m) = hand.wrist_turn_radius_m() else {
            return *self;
        };
        let [first_m, second_m] = self.tangential_m.into_array();
        let turn_rad = (first_m - second_m) / 2.0 / radius_m;
        GraspPose {
            closing_yaw_rad: self.closing_yaw_rad + turn_rad,
            tangential_m: PerSide::repeat((first_m + second_m) / 2.0),
            ..*self
        }
    }

    /// Returns tips, dome axes and hand axis of this grasp for `hand`, including the dome radius.
    #[must_use]
    pub fn target(&self, hand: &HandModel) -> HandTarget {
        self.executed_by(hand).target_of_tips(hand)
    }

    fn target_of_tips(&self, hand: &HandModel) -> HandTarget {
        let n = self.closing_axis();
        let t = Vector3::new(-n.y, n.x, 0.0);
        let hand_axis = self.hand_axis();
        let beside = n.cross(&hand_axis);
        let mut target = HandTarget {
            tip_m: [Vector3::zeros(); FINGERTIPS_MAX],
            dome_axis: [Vector3::zeros(); FINGERTIPS_MAX],
            hand_axis,
            root_rad: self.root_rad,
        };
        for (finger, model) in hand.fingers[..hand.finger_count].iter().enumerate() {
            let side = model.side;
            let outward = n * side.outward();
            target.tip_m[finger] = self.centre_m
                + outward * (self.half_opening_m[side] + hand.tip_radius_m[finger])
                + t * self.tangential_m[side]
                + Vector3::z() * self.up_m[side]
                + beside * model.offset_m;
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
