//! Two-wheeled base with limited acceleration and jerk of each wheel; a [`Pace`] scales the limits.

use core::f64::consts::PI;

use field::Wheels;

use super::floor::Floor;
use crate::base_motion::BaseMotion;

/// Step, s: the period of the wheel controllers.
pub const STEP_S: f64 = 0.005;
/// Wheel speed at the medium level, m/s.
const MEDIUM_M_S: f64 = 0.15;
/// Wheel speed at the high level, m/s.
pub const HIGH_M_S: f64 = 2.0 * MEDIUM_M_S;
/// Distance between the wheels, m.
const TRACK_M: f64 = 0.30;
pub(super) const HALF_TRACK_M: f64 = TRACK_M / 2.0;
/// Limits of a wheel's acceleration, m/s², and jerk, m/s³.
const ACCELERATION_M_S2: f64 = 0.8;
const JERK_M_S3: f64 = 8.0;
/// Share of all limits while carrying. Design choice: at full pace, turns and bumps shake out
/// objects that need almost the whole allowed grip force.
const CARRYING_SHARE: f64 = 0.5;

/// Scale of the speed and acceleration limits.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Pace {
    /// Full limits.
    #[default]
    Free,
    /// Reduced limits while carrying.
    Carrying,
}

impl Pace {
    fn share(self) -> f64 {
        match self {
            Self::Free => 1.0,
            Self::Carrying => CARRYING_SHARE,
        }
    }
}

/// Position and direction in the field.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PlanarPose {
    /// Position x and y, m.
    pub position_m: [f64; 2],
    /// Direction, rad.
    pub yaw_rad: f64,
}

impl PlanarPose {
    /// Transforms a point of the field into this frame: metres ahead and to the left.
    #[must_use]
    pub fn relative_m(&self, point_m: [f64; 2]) -> [f64; 2] {
        let (sin, cos) = libm::sincos(self.yaw_rad);
        let [dx, dy] = [
            point_m[0] - self.position_m[0],
            point_m[1] - self.position_m[1],
        ];
        [dx * cos + dy * sin, dy * cos - dx * sin]
    }

    /// Transforms a point of this frame into the field.
    #[must_use]
    pub fn point_m(&self, [ahead_m, left_m]: [f64; 2]) -> [f64; 2] {
        let (sin, cos) = libm::sincos(self.yaw_rad);
        [
            self.position_m[0] + ahead_m * cos - left_m * sin,
            self.position_m[1] + ahead_m * sin + left_m * cos,
        ]
    }
}

#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Wheel {
    speed_m_s: f64,
    acceleration_m_s2: f64,
}

impl Wheel {
    /// Steps towards a level; returns initial speed and mean acceleration.
    fn drive(&mut self, level: u8, pace: Pace) -> [f64; 2] {
        let target_m_s = f64::from(level.min(2)) * MEDIUM_M_S * pace.share();
        let (before_m_s, missing_m_s) = (self.speed_m_s, target_m_s - self.speed_m_s);
        let jerk_m_s3 = JERK_M_S3 * pace.share();
        let jerk_step = jerk_m_s3 * STEP_S;
        let nearly = missing_m_s.abs() <= jerk_step * STEP_S;
        if nearly && self.acceleration_m_s2.abs() <= 2.0 * jerk_step {
            (self.speed_m_s, self.acceleration_m_s2) = (target_m_s, 0.0);
            return [before_m_s, missing_m_s / STEP_S];
        }
        // Largest acceleration that the jerk limit can reduce to zero at the target speed.
        let easing = (2.0 * jerk_m_s3 * missing_m_s.abs()).sqrt();
        let most = ACCELERATION_M_S2 * pace.share();
        let wanted = easing.min(most).copysign(missing_m_s);
        let change = (wanted - self.acceleration_m_s2).clamp(-jerk_step, jerk_step);
        self.acceleration_m_s2 += change;
        self.speed_m_s += self.acceleration_m_s2 * STEP_S;
        [before_m_s, self.acceleration_m_s2]
    }
}

/// Wheeled base.
#[derive(Clone, Debug)]
pub struct Base {
    pose: PlanarPose,
    wheels: [Wheel; 2],
    floor: Floor,
    motion: BaseMotion,
}

impl Base {
    /// Creates a base at rest.
    #[must_use]
    pub fn new(place: PlanarPose, floor: Floor) -> Self {
        Self {
            pose: place,
            wheels: [Wheel::default(); 2],
            floor,
            motion: BaseMotion::STILL,
        }
    }

    /// Copies the base onto a floor without bumps; its planar motion is identical.
    #[must_use]
    pub(super) fn on_even_floor(&self) -> Self {
        Self {
            floor: Floor::even(),
            ..self.clone()
        }
    }

    /// Steps towards these wheel levels.
    pub fn step(&mut self, levels: Wheels, pace: Pace) {
        let [left, right] = &mut self.wheels;
        let left = left.drive(levels.left, pace);
        let right = right.drive(levels.right, pace);
        let mean = |k: usize| (left[k] + right[k]) / 2.0;
        let turn = |k: usize| (right[k] - left[k]) / TRACK_M;
        let way_m = (mean(0) + mean(1) * STEP_S / 2.0) * STEP_S;
        let turned_rad = (turn(0) + turn(1) * STEP_S / 2.0) * STEP_S;
        self.motion = BaseMotion {
            speed_m_s: mean(0),
            acceleration_m_s2: mean(1),
            turn_rad_s: turn(0),
            turn_rad_s2: turn(1),
            heave_m_s2: self.floor.heave_m_s2(way_m, mean(0)),
        };
        let middle_rad = self.pose.yaw_rad + turned_rad / 2.0;
        let (sin, cos) = libm::sincos(middle_rad);
        self.pose.position_m[0] += way_m * cos;
        self.pose.position_m[1] += way_m * sin;
        self.pose.yaw_rad = wrapped(self.pose.yaw_rad + turned_rad);
    }

    /// Returns the pose.
    #[must_use]
    pub fn pose(&self) -> PlanarPose {
        self.pose
    }

    /// Returns the motion in the current step, from its start.
    #[must_use]
    pub fn motion(&self) -> BaseMotion {
        self.motion
    }

    /// Returns true if both wheels are at rest.
    #[must_use]
    pub fn is_at_rest(&self) -> bool {
        self.wheels == [Wheel::default(); 2]
    }
}

fn wrapped(angle_rad: f64) -> f64 {
    if angle_rad > PI {
        angle_rad - 2.0 * PI
    } else if angle_rad < -PI {
        angle_rad + 2.0 * PI
    } else {
        angle_rad
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn base() -> Base {
        Base::new(PlanarPose::default(), Floor::even())
    }

    #[test]
    fn wheels_reach_and_keep_their_speed() {
        for (level, pace) in [1, 2, 0]
            .map(|l| [(l, Pace::Free), (l, Pace::Carrying)])
            .concat()
        {
            let mut base = base();
            let levels = Wheels {
                left: level,
                right: level,
            };
            (0..400).for_each(|_| base.step(levels, pace));
            let speed_m_s = f64::from(level) * MEDIUM_M_S * pace.share();
            assert_eq!(base.motion().speed_m_s, speed_m_s);
            (0..400).for_each(|_| base.step(Wheels::STOP, pace));
            assert!(base.is_at_rest() && base.motion() == BaseMotion::STILL);
            assert_eq!(
                base.pose().position_m[1],
                0.0,
                "equal levels drive straight"
            );
        }
    }

    proptest! {
        /// Limits hold for any sequence of levels.
        #[test]
        fn limits_hold_for_any_levels(
            levels in proptest::collection::vec((0_u8..4, 0_u8..4), 1..40),
            pace in prop_oneof![Just(Pace::Free), Just(Pace::Carrying)],
        ) {
            let (mut base, mut before, share) = (base(), BaseMotion::STILL, pace.share());
            for (left, right) in levels {
                for _ in 0..20 {
                    base.step(Wheels { left, right }, pace);
                    let ride = base.motion();
                    prop_assert!(ride.speed_m_s.abs() <= share * HIGH_M_S * 1.05);
                    prop_assert!(ride.acceleration_m_s2.abs() <= share * ACCELERATION_M_S2 + 1e-9);
                    let jerk = (ride.acceleration_m_s2 - before.acceleration_m_s2).abs() / STEP_S;
                    // A wheel near its target speed reaches it within one step.
                    prop_assert!(jerk <= 3.0 * share * JERK_M_S3 + 1e-6, "{jerk} m/s³");
                    prop_assert!(base.pose().yaw_rad.abs() <= PI);
                    before = ride;
                }
            }
        }
    }

    #[test]
    fn pose_transforms_are_inverse() {
        let place = PlanarPose {
            position_m: [1.0, -2.0],
            yaw_rad: 0.7,
        };
        let point_m = place.point_m([0.3, -0.1]);
        let [ahead_m, left_m] = place.relative_m(point_m);
        assert!((ahead_m - 0.3).abs() < 1e-12 && (left_m + 0.1).abs() < 1e-12);
    }
}
