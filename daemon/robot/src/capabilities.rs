//! Capabilities of a hand, found by inverse kinematics around its home pose.

use crate::grasp_sides::PerSide;
use core::f64::consts::{FRAC_PI_2, FRAC_PI_4};

use nalgebra::Vector3;

use crate::model::HandModel;
use crate::solve::{POSTURE_DOME_ERROR_MAX_RAD, Unreachable};
use crate::target::GraspPose;

/// Vertical motion from home, up or down, that lifting needs, m. Design choice: the height of a
/// small lift.
const RISE_M: f64 = 0.02;
/// Horizontal motion from home that carrying needs, m. Design choice: enough to set an object down
/// next to its start.
const CARRY_M: f64 = 0.05;
/// Shift, m, and turn, rad, that a lateral shift needs. Design choice: the errors of placement that
/// tasks correct.
const SHIFT_M: f64 = 0.009;
const TURN_RAD: f64 = 0.26;
/// Largest opening that is tried, m, and number of bisections (to 0.1 mm).
const OPEN_MAX_M: f64 = 0.4;
const HALVINGS: usize = 12;
/// Number of openings, from closed to widest, at which tilt and speed are examined. Design choice.
const OPENINGS: usize = 8;
/// Distance by which each fingertip must pass the other, m. Design choice: a sixth of a turn of the
/// smallest cap.
const PASS_M: f64 = 0.006;
/// Smallest cosine between actual and required hand axis of a side grasp. Design choice: 15°.
const SIDE_GRASP_COS_MIN: f64 = 0.966;
/// Cap width at which turning is tried, m.
const CAP_M: f64 = 0.03;

/// Capabilities of a hand that tasks require.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Capabilities {
    /// The hand can lift. Every task needs this.
    pub lift: bool,
    /// The hand can carry an object to another place over the table.
    pub carry: bool,
    /// The hand can turn a cap: its fingertips can pass each other, or its wrist turns the hand.
    pub cap_turning: bool,
    /// The wrist turns the cap.
    pub cap_turning_by_wrist: bool,
    /// The hand can grasp from the side, pitched 45°. The hand that holds a bottle needs this.
    pub side_grasp: bool,
}

impl HandModel {
    /// Determines the capabilities. Takes some milliseconds, so it is not for the tick.
    ///
    /// ```
    /// # #[cfg(feature = "std")] {
    /// use robot_model::{HandSide, RobotModel};
    ///
    /// let robot = RobotModel::find("arm7-gripper")?;
    /// let capabilities = robot.hand(HandSide::Right).capabilities();
    /// assert!(capabilities.lift && capabilities.carry);
    /// # }
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[must_use]
    pub fn capabilities(&self) -> Capabilities {
        let moved = |by_m: Vector3<f64>| self.reaches_near_home(by_m, 0.0);
        let either = |axis: Vector3<f64>, by_m: f64| moved(axis * by_m) || moved(axis * -by_m);
        // Each of several fingertips of a side must meet the cap.
        let fits_cap = self.fingers[..self.finger_count]
            .iter()
            .all(|finger| libm::fabs(finger.offset_m) < CAP_M / 4.0);
        Capabilities {
            lift: self.is_present() && either(Vector3::z(), RISE_M),
            carry: self.is_present()
                && either(Vector3::x(), CARRY_M)
                && either(Vector3::y(), CARRY_M),
            cap_turning: self.is_present() && fits_cap && self.turns_both_ways(),
            cap_turning_by_wrist: self.turns_by_wrist,
            side_grasp: self.is_present() && self.can_grasp_from_side(),
        }
    }

    /// Returns true if the hand at home can point 45° down and straight away from its base, with
    /// its fingertips to its left and right. The inverse kinematics gives hand direction a lower
    /// priority than the fingertips, so the direction is verified separately.
    fn can_grasp_from_side(&self) -> bool {
        let azimuth_rad = self.bearing_rad(&self.home_m);
        let grasp = GraspPose {
            hand_azimuth_rad: azimuth_rad,
            hand_pitch_rad: FRAC_PI_4,
            ..GraspPose::from_above(self.home_m, azimuth_rad + FRAC_PI_2, self.home_opening_m)
        };
        self.posture_for(&grasp).is_ok_and(|found| {
            let points = self.forward(&found.q).hand_axis();
            points.dot(&grasp.target(self).hand_axis) > SIDE_GRASP_COS_MIN
        })
    }

    /// Returns true if the hand reaches a place next to home, turned against the home yaw.
    fn reaches_near_home(&self, by_m: Vector3<f64>, turned_rad: f64) -> bool {
        let (centre_m, yaw_rad) = (self.home_m + by_m, self.home_yaw_rad + turned_rad);
        let frame = GraspPose::from_above(centre_m, yaw_rad, self.home_opening_m);
        self.posture_for(&frame).is_ok()
    }

    /// Returns true if the domes cannot face each other within 1° at every opening. Turning jaws,
    /// such as one fixed and one hinged jaw, face each other at one opening only.
    #[must_use]
    pub fn domes_tilt(&self) -> bool {
        self.domes_tilt
    }

    /// Largest angle between a dome and the closing axis in contact, radians: 1°, or the tolerance
    /// of the skin if the domes tilt.
    #[must_use]
    pub fn dome_error_max_rad(&self) -> f64 {
        let bears_rad = |radius_m: &f64| self.skin.tilt_max_rad(*radius_m).unwrap_or(0.0);
        let tilted_rad = self.tip_radius_m().iter().map(bears_rad);
        let tilted_rad = tilted_rad
            .filter(|_| self.domes_tilt)
            .fold(f64::INFINITY, f64::min);
        if tilted_rad.is_finite() {
            tilted_rad.max(POSTURE_DOME_ERROR_MAX_RAD)
        } else {
            POSTURE_DOME_ERROR_MAX_RAD
        }
    }

    /// Returns the largest angle between a dome and the closing axis at home, closed to
    /// `opening_m`, radians; `None` if the fingertips do not reach that opening.
    #[must_use]
    pub fn dome_error_at_home_rad(&self, opening_m: f64) -> Option<f64> {
        let frame = GraspPose::from_above(self.home_m, self.home_yaw_rad, opening_m);
        let best = match self.posture_for(&frame) {
            Ok(best) | Err(Unreachable { best, .. }) => best,
        };
        best.meets_tips().then_some(best.dome_error_rad)
    }

    /// Examines openings up to that of home.
    fn find_domes_tilt(&self) -> bool {
        let step_m = self.home_opening_m / OPENINGS as f64;
        (1..=OPENINGS).any(|step| {
            self.dome_error_at_home_rad(step_m * step as f64)
                .is_some_and(|error_rad| error_rad > POSTURE_DOME_ERROR_MAX_RAD)
        })
    }

    /// Returns true if the hand at home reaches both ends of a cap turn. Fingertips may turn only
    /// as far as domes without tilt, because a hand that turns as a whole does not move one
    /// fingertip past the other.
    fn turns_both_ways(&self) -> bool {
        [PASS_M, -PASS_M].into_iter().all(|by_m| {
            let frame = GraspPose {
                tangential_m: PerSide::new(by_m, -by_m),
                ..GraspPose::from_above(self.home_m, self.home_yaw_rad, CAP_M)
            };
            let dome_error_max_rad = if self.turns_by_wrist {
                self.dome_error_max_rad()
            } else {
                POSTURE_DOME_ERROR_MAX_RAD
            };
            self.posture_within(&frame, dome_error_max_rad).is_ok()
        })
    }

    /// Returns the largest opening at home, at least the home opening. If the domes tilt, tilt
    /// grows with the opening and reach at home does not prove reach elsewhere, so this is the home
    /// opening.
    fn find_max_opening_m(&self) -> f64 {
        if self.domes_tilt {
            return self.home_opening_m;
        }
        let (mut reached_m, mut beyond_m) = (self.home_opening_m, OPEN_MAX_M);
        for _ in 0..HALVINGS {
            let opening_m = (reached_m + beyond_m) / 2.0;
            let frame = GraspPose::from_above(self.home_m, self.home_yaw_rad, opening_m);
            if self.posture_for(&frame).is_ok() {
                reached_m = opening_m;
            } else {
                beyond_m = opening_m;
            }
        }
        reached_m
    }

    /// Returns the finger speed from the time that the finger joints need between openings.
    fn find_finger_speed_m_s(&self) -> f64 {
        let step_m = self.max_opening_m / OPENINGS as f64;
        let posture = |step: usize| {
            let opening_m = self.max_opening_m - step_m * step as f64;
            let frame = GraspPose::from_above(self.home_m, self.home_yaw_rad, opening_m);
            self.posture_for(&frame).ok().map(|found| found.q)
        };
        let mut slowest_m_s = f64::INFINITY;
        for step in 0..OPENINGS {
            if let (Some(from), Some(to)) = (posture(step), posture(step + 1)) {
                for joint in self.arm_joints..self.joint_count {
                    let takes_s =
                        libm::fabs(to[joint] - from[joint]) / self.joints[joint].velocity_max;
                    slowest_m_s = slowest_m_s.min(step_m / 2.0 / takes_s);
                }
            }
        }
        slowest_m_s
    }

    /// Determines dome tilt, largest opening, finger speed, whether caps need the wrist, and
    /// whether the hand can shift and turn slightly.
    pub(crate) fn find_capabilities(&mut self) {
        self.domes_tilt = self.find_domes_tilt();
        self.max_opening_m = self.find_max_opening_m();
        self.finger_speed_m_s = self.find_finger_speed_m_s();
        self.turns_by_wrist = self.turning.wrist.is_some() && !self.turns_both_ways();
        let moves = |axis: Vector3<f64>, sign: f64| {
            self.reaches_near_home(axis * (sign * SHIFT_M), sign * TURN_RAD)
        };
        self.lateral_shift = [Vector3::x(), Vector3::y()]
            .into_iter()
            .all(|axis| moves(axis, 1.0) && moves(axis, -1.0));
    }
}
