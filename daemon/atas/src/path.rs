//! Paths of a hand between two grasp poses.
//!
//! Every coordinate of the [`GraspPose`] follows the minimum-jerk profile s(τ) = τ³(10 − 15τ +
//! 6τ²): rest to rest, bounded jerk, shape independent of speed. Obstacles on the table are
//! unknown, so a path over it has two legs: up before across, or across before down.

use core::f64::consts::PI;
use nalgebra::Vector3;
use robot_model::{GraspPose, GraspSide, HandModel, PerSide};

/// Shortest duration, s. Design choice: lets the loop settle on a zero-length path.
const DURATION_MIN_S: f64 = 0.05;
/// Rise or lateral distance below which a path is straight, m. Design choice: less than any
/// clearance.
const STRAIGHT_BELOW_M: f64 = 0.001;

/// Peak/mean speed of the minimum-jerk profile.
pub(crate) const PEAK_TO_MEAN_SPEED: f64 = 1.875;

/// Largest mean speeds of a path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Speeds {
    /// Centre, m/s.
    pub move_m_s: f64,
    /// Yaw, azimuth, pitch and roots, rad/s.
    pub turn_rad_s: f64,
    /// Opening and tangential offset of each side, m/s.
    pub open_m_s: f64,
    /// Radius at which the wrist executes opposite tangential offsets, m; `None`: the fingers do.
    pub wrist_turn_radius_m: Option<f64>,
}

/// Path between two poses.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Path {
    from: GraspPose,
    /// Start pose of the second leg, at `corner_s`; a straight path has only this leg.
    corner: GraspPose,
    corner_s: f64,
    to: GraspPose,
    duration_s: f64,
    moves_fingers: bool,
}

impl Path {
    /// Creates a path that keeps the hand at its pose.
    #[must_use]
    pub fn stationary(at: GraspPose) -> Self {
        Self {
            from: at,
            corner: at,
            corner_s: 0.0,
            to: at,
            duration_s: 0.0,
            moves_fingers: false,
        }
    }

    /// Creates a path that moves hand and fingers to a pose.
    ///
    /// ```
    /// use atas_core::path::{Path, Speeds};
    /// use nalgebra::Vector3;
    /// use robot_model::GraspPose;
    ///
    /// let at = |x_m| GraspPose::from_above(Vector3::new(x_m, 0.0, 0.1), 0.0, 0.05);
    /// let speeds = Speeds {
    ///     move_m_s: 0.1,
    ///     turn_rad_s: 1.0,
    ///     open_m_s: 0.05,
    ///     wrist_turn_radius_m: None,
    /// };
    /// let path = Path::free(at(0.2), at(0.3), &speeds);
    /// assert!((path.duration_s() - 1.0).abs() < 1e-9, "100 mm at a mean speed of 100 mm/s");
    /// assert!((path.pose_at(0.5).centre_m.x - 0.25).abs() < 1e-9);
    /// ```
    #[must_use]
    pub fn free(from: GraspPose, to: GraspPose, speeds: &Speeds) -> Self {
        Self {
            duration_s: duration_s(&from, &to, speeds),
            from,
            to,
            moves_fingers: true,
            ..Self::stationary(from)
        }
    }

    /// Creates a path over obstacles up to its higher end: rises first or descends last.
    #[must_use]
    pub fn over_obstacles(from: GraspPose, to: GraspPose, speeds: &Speeds) -> Self {
        let way_m = to.centre_m - from.centre_m;
        let straight = Self::free(from, to, speeds);
        if way_m.z.abs() < STRAIGHT_BELOW_M || way_m.xy().norm() < STRAIGHT_BELOW_M {
            return straight;
        }
        let corner = if way_m.z > 0.0 {
            with_height(&from, to.centre_m.z)
        } else {
            with_height(&to, from.centre_m.z)
        };
        let corner_s = duration_s(&from, &corner, speeds);
        Self {
            corner,
            corner_s,
            duration_s: corner_s + duration_s(&corner, &to, speeds),
            ..straight
        }
    }

    /// Creates a path that leaves the fingers to the modules.
    #[must_use]
    pub fn gripping(from: GraspPose, to: GraspPose, speeds: &Speeds) -> Self {
        let to = GraspPose {
            half_opening_m: from.half_opening_m,
            ..to
        };
        Self {
            moves_fingers: false,
            ..Self::free(from, to, speeds)
        }
    }

    /// Returns the duration at full speed, s.
    #[must_use]
    pub fn duration_s(&self) -> f64 {
        self.duration_s
    }

    /// Returns the end pose.
    #[must_use]
    pub fn end(&self) -> &GraspPose {
        &self.to
    }

    /// Returns the end poses of both legs; the first may equal the start pose.
    #[must_use]
    pub fn leg_ends(&self) -> [GraspPose; 2] {
        [self.corner, self.to]
    }

    /// Returns whether the path moves the fingers.
    #[must_use]
    pub fn moves_fingers(&self) -> bool {
        self.moves_fingers
    }

    /// Returns the pose at a time, s.
    #[must_use]
    pub fn pose_at(&self, time_s: f64) -> GraspPose {
        if time_s >= self.duration_s {
            return self.to;
        }
        if time_s < self.corner_s {
            return blend(
                &self.from,
                &self.corner,
                minimum_jerk_share(time_s / self.corner_s),
            );
        }
        let tau = (time_s - self.corner_s) / (self.duration_s - self.corner_s);
        blend(&self.corner, &self.to, minimum_jerk_share(tau))
    }
}

/// Minimum-jerk profile s(τ).
fn minimum_jerk_share(tau: f64) -> f64 {
    tau * tau * tau * (10.0 - 15.0 * tau + 6.0 * tau * tau)
}

/// Returns the pose at another height, m.
#[must_use]
pub fn with_height(frame: &GraspPose, height_m: f64) -> GraspPose {
    let mut frame = *frame;
    frame.centre_m.z = height_m;
    frame
}

/// Interpolates linearly between two poses, `s` from 0 to 1.
#[must_use]
pub fn blend(a: &GraspPose, b: &GraspPose, s: f64) -> GraspPose {
    let mix = |a: f64, b: f64| a + (b - a) * s;
    let mix2 = |a: PerSide<f64>, b: PerSide<f64>| a.zip_map(b, mix);
    GraspPose {
        centre_m: a.centre_m + (b.centre_m - a.centre_m) * s,
        closing_yaw_rad: mix(a.closing_yaw_rad, b.closing_yaw_rad),
        hand_azimuth_rad: mix(a.hand_azimuth_rad, b.hand_azimuth_rad),
        hand_pitch_rad: mix(a.hand_pitch_rad, b.hand_pitch_rad),
        root_rad: mix(a.root_rad, b.root_rad),
        half_opening_m: mix2(a.half_opening_m, b.half_opening_m),
        tangential_m: mix2(a.tangential_m, b.tangential_m),
        up_m: mix2(a.up_m, b.up_m),
    }
}

fn duration_s(from: &GraspPose, to: &GraspPose, speeds: &Speeds) -> f64 {
    let [first_m, second_m] = GraspSide::BOTH.map(|f| to.tangential_m[f] - from.tangential_m[f]);
    let (wrist_rad, slides) = match speeds.wrist_turn_radius_m {
        Some(radius_m) => {
            let common_m = (first_m + second_m) / 2.0;
            ((first_m - second_m) / 2.0 / radius_m, [common_m; 2])
        }
        None => (0.0, [first_m, second_m]),
    };
    let turns = [
        to.closing_yaw_rad - from.closing_yaw_rad + wrist_rad,
        to.hand_azimuth_rad - from.hand_azimuth_rad,
        to.hand_pitch_rad - from.hand_pitch_rad,
        to.root_rad - from.root_rad,
    ];
    let opening = GraspSide::BOTH
        .into_iter()
        .map(|f| to.half_opening_m[f] - from.half_opening_m[f]);
    let largest = |values: &mut dyn Iterator<Item = f64>| {
        values.fold(0.0, |m: f64, v| if v.abs() > m { v.abs() } else { m })
    };
    [
        (to.centre_m - from.centre_m).norm() / speeds.move_m_s,
        largest(&mut turns.into_iter()) / speeds.turn_rad_s,
        largest(&mut opening.chain(slides)) / speeds.open_m_s,
        DURATION_MIN_S,
    ]
    .into_iter()
    .fold(0.0, f64::max)
}

/// Returns the equivalent grasp yaw within a quarter turn of the wrist, unwound for the shortest
/// rotation from `from`, rad.
#[must_use]
pub fn reachable_yaw_rad(
    hand: &HandModel,
    from: &GraspPose,
    centre_m: &Vector3<f64>,
    yaw_rad: f64,
) -> f64 {
    let yaw_rad = hand.closing_yaw_rad(centre_m, yaw_rad);
    // Wrist roll = bearing + constant − yaw: with both rolls within a quarter turn, the yaw change
    // is unambiguous.
    let bearing_change = hand.bearing_rad(centre_m) - hand.bearing_rad(&from.centre_m);
    let ahead = yaw_rad - from.closing_yaw_rad - bearing_change;
    from.closing_yaw_rad + bearing_change + ahead - 2.0 * PI * libm::round(ahead / (2.0 * PI))
}
