//! Paths: how a hand gets from one pose to another.
//!
//! Every coordinate of the [`GraspFrame`] follows the same minimum-jerk profile s(τ) = τ³(10 − 15τ + 6τ²), so a path
//! begins and ends at rest with bounded jerk, and its shape does not depend on its speed. What stands on the table is not
//! known, so a free way over it has two legs, each of this profile: it rises before it crosses, and sinks after it has crossed.

use core::f64::consts::PI;
use nalgebra::Vector3;
use robot_model::{GraspFrame, HandModel, VIRTUAL_FINGERS};

/// Shortest path, s (ours): even a zero-length path gives the loop time to settle.
const DURATION_MIN_S: f64 = 0.05;
/// Rise, or way across, below which a path over is straight, m (ours: less than any gap that a hand keeps).
const LEVEL_M: f64 = 0.001;

/// Peak speed of a minimum-jerk profile over its mean.
pub(crate) const PEAK_OF_MEAN: f64 = 1.875;

/// Mean speeds that no coordinate of a path exceeds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Speeds {
    /// Of the centre, m/s.
    pub move_m_s: f64,
    /// Of yaw, azimuth, pitch and roots, rad/s.
    pub turn_rad_s: f64,
    /// Of each finger's opening, m/s.
    pub open_m_s: f64,
}

/// One path between two poses.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Path {
    from: GraspFrame,
    /// Where the second leg begins, and when, s; a straight path has no first one.
    corner: GraspFrame,
    corner_s: f64,
    to: GraspFrame,
    duration_s: f64,
    moves_fingers: bool,
}

impl Path {
    /// A path that keeps the hand where it is.
    #[must_use]
    pub fn stay(at: GraspFrame) -> Self {
        Self {
            from: at,
            corner: at,
            corner_s: 0.0,
            to: at,
            duration_s: 0.0,
            moves_fingers: false,
        }
    }

    /// A path that carries hand and fingers to a pose.
    #[must_use]
    pub fn free(from: GraspFrame, to: GraspFrame, speeds: &Speeds) -> Self {
        Self {
            duration_s: duration_s(&from, &to, speeds),
            from,
            to,
            moves_fingers: true,
            ..Self::stay(from)
        }
    }

    /// A free path that passes over whatever is not higher than its higher end: it rises first, or sinks last.
    #[must_use]
    pub fn over(from: GraspFrame, to: GraspFrame, speeds: &Speeds) -> Self {
        let way_m = to.centre_m - from.centre_m;
        let straight = Self::free(from, to, speeds);
        if way_m.z.abs() < LEVEL_M || way_m.xy().norm() < LEVEL_M {
            return straight;
        }
        let corner = if way_m.z > 0.0 {
            at_height(&from, to.centre_m.z)
        } else {
            at_height(&to, from.centre_m.z)
        };
        let corner_s = duration_s(&from, &corner, speeds);
        Self {
            corner,
            corner_s,
            duration_s: corner_s + duration_s(&corner, &to, speeds),
            ..straight
        }
    }

    /// A path that carries the hand and leaves the fingers to the modules.
    #[must_use]
    pub fn gripping(from: GraspFrame, to: GraspFrame, speeds: &Speeds) -> Self {
        let to = GraspFrame {
            half_opening_m: from.half_opening_m,
            ..to
        };
        Self {
            moves_fingers: false,
            ..Self::free(from, to, speeds)
        }
    }

    /// How long the path takes at full speed, s.
    #[must_use]
    pub fn duration_s(&self) -> f64 {
        self.duration_s
    }

    /// Where the path ends.
    #[must_use]
    pub fn end(&self) -> &GraspFrame {
        &self.to
    }

    /// Where its legs end, in order; the first may be where it begins.
    #[must_use]
    pub fn ends(&self) -> [GraspFrame; 2] {
        [self.corner, self.to]
    }

    /// Whether the path includes the opening of the fingers.
    #[must_use]
    pub fn moves_fingers(&self) -> bool {
        self.moves_fingers
    }

    /// The pose after some time on the path, s.
    #[must_use]
    pub fn at(&self, time_s: f64) -> GraspFrame {
        if time_s >= self.duration_s {
            return self.to;
        }
        if time_s < self.corner_s {
            return blend(&self.from, &self.corner, eased(time_s / self.corner_s));
        }
        let tau = (time_s - self.corner_s) / (self.duration_s - self.corner_s);
        blend(&self.corner, &self.to, eased(tau))
    }
}

/// Share of a leg after this share of its time.
fn eased(tau: f64) -> f64 {
    tau * tau * tau * (10.0 - 15.0 * tau + 6.0 * tau * tau)
}

/// The same pose at another height, m.
#[must_use]
pub fn at_height(frame: &GraspFrame, height_m: f64) -> GraspFrame {
    let mut frame = *frame;
    frame.centre_m.z = height_m;
    frame
}

/// The pose at a share of the straight way between two, 0 to 1.
#[must_use]
pub fn blend(a: &GraspFrame, b: &GraspFrame, s: f64) -> GraspFrame {
    let mix = |a: f64, b: f64| a + (b - a) * s;
    let mix2 = |a: [f64; VIRTUAL_FINGERS], b: [f64; VIRTUAL_FINGERS]| {
        core::array::from_fn(|i| mix(a[i], b[i]))
    };
    GraspFrame {
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

fn duration_s(from: &GraspFrame, to: &GraspFrame, speeds: &Speeds) -> f64 {
    let turns = [
        to.closing_yaw_rad - from.closing_yaw_rad,
        to.hand_azimuth_rad - from.hand_azimuth_rad,
        to.hand_pitch_rad - from.hand_pitch_rad,
        to.root_rad - from.root_rad,
    ];
    let opening = (0..VIRTUAL_FINGERS).map(|f| to.half_opening_m[f] - from.half_opening_m[f]);
    let slides = (0..VIRTUAL_FINGERS).map(|f| to.tangential_m[f] - from.tangential_m[f]);
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

/// The yaw, equivalent to `yaw_rad` for the grasp, that the hand reaches from `from` without turning its wrist beyond
/// a quarter turn; unwound so that the path to it turns the short way.
#[must_use]
pub fn reachable_yaw_rad(
    hand: &HandModel,
    from: &GraspFrame,
    centre_m: &Vector3<f64>,
    yaw_rad: f64,
) -> f64 {
    let yaw_rad = hand.closing_yaw_rad(centre_m, yaw_rad);
    // The wrist roll is bearing + what is constant − yaw: with both rolls within a quarter turn the yaw change is unambiguous.
    let bearing_change = hand.bearing_rad(centre_m) - hand.bearing_rad(&from.centre_m);
    let ahead = yaw_rad - from.closing_yaw_rad - bearing_change;
    from.closing_yaw_rad + bearing_change + ahead - 2.0 * PI * libm::round(ahead / (2.0 * PI))
}
