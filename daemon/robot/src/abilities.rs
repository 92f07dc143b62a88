//! What a hand can do of what tasks need, tried by the inverse kinematics about where it rests.

use core::f64::consts::{FRAC_PI_2, FRAC_PI_4};

use nalgebra::Vector3;

use crate::model::HandModel;
use crate::solve::{POSTURE_DOME_ERROR_MAX_RAD, Unreachable};
use crate::target::GraspFrame;

/// How far it must be able to rise from where it rests, or sink, m (ours: a lift).
const RISE_M: f64 = 0.02;
/// How far it must be able to go aside, m (ours: enough to set an object down beside where it stood).
const ASIDE_M: f64 = 0.05;
/// What it must be able to shift, m, and turn, rad, to be called able to do so a little (ours: what places may be wrong by).
const LITTLE_M: f64 = 0.009;
const LITTLE_RAD: f64 = 0.26;
/// Farthest that a hand is tried to open, m, and how often the opening is halved to find the widest (ours: to 0.1 mm).
const OPEN_MAX_M: f64 = 0.4;
const HALVINGS: usize = 12;
/// Openings between the widest and none at which its speed is found (ours).
const OPENINGS: usize = 8;
/// How far each fingertip must be able to pass the other, m (ours: a sixth of a turn of the smallest cap).
const PASS_M: f64 = 0.006;
/// Smallest cosine between where a hand that slants points and where it should (ours: 15°).
const SLANT_COS_MIN: f64 = 0.966;
/// How wide a cap is that it is tried on, m.
const CAP_M: f64 = 0.03;

/// What a hand can do of what tasks need.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Abilities {
    /// It can lift: every task needs that.
    pub lifts: bool,
    /// It can carry an object to another place over the table.
    pub carries: bool,
    /// It can turn a cap between its fingertips: they can pass each other, or its wrist turns it.
    pub turns_caps: bool,
    /// It does so by its wrist.
    pub turns_by_wrist: bool,
    /// It can grasp slanting from the side, as what holds a bottle for the other hand must.
    pub slants: bool,
}

impl HandModel {
    /// What the hand can do; some milliseconds of computing, so not for the tick.
    #[must_use]
    pub fn abilities(&self) -> Abilities {
        let moved = |by_m: Vector3<f64>| self.reaches_beside_home(by_m, 0.0);
        let either = |axis: Vector3<f64>, by_m: f64| moved(axis * by_m) || moved(axis * -by_m);
        // Of several fingertips that press from one side, each must meet the cap.
        let fits_cap = self.fingers[..self.finger_count]
            .iter()
            .all(|finger| libm::fabs(finger.beside_m) < CAP_M / 4.0);
        Abilities {
            lifts: self.is_present() && either(Vector3::z(), RISE_M),
            carries: self.is_present()
                && either(Vector3::x(), ASIDE_M)
                && either(Vector3::y(), ASIDE_M),
            turns_caps: self.is_present() && fits_cap && self.turns_both_ways(),
            turns_by_wrist: self.turns_by_wrist,
            slants: self.is_present() && self.slants(),
        }
    }

    /// Whether it can point halfway down and straight away from its base where it rests, its fingertips to its left and right. What
    /// direction a hand has comes after what its fingertips do, so that is asked for by itself.
    fn slants(&self) -> bool {
        let azimuth_rad = self.bearing_rad(&self.home_m);
        let grasp = GraspFrame {
            hand_azimuth_rad: azimuth_rad,
            hand_pitch_rad: FRAC_PI_4,
            ..GraspFrame::from_above(self.home_m, azimuth_rad + FRAC_PI_2, self.home_opening_m)
        };
        self.posture_for(&grasp).is_ok_and(|found| {
            let points = self.forward(&found.q_rad).hand_axis();
            points.dot(&grasp.target(self).hand_axis) > SLANT_COS_MIN
        })
    }

    /// Whether it reaches a place beside where it rests, turned against how it rests.
    fn reaches_beside_home(&self, by_m: Vector3<f64>, turned_rad: f64) -> bool {
        let (centre_m, yaw_rad) = (self.home_m + by_m, self.home_yaw_rad + turned_rad);
        let frame = GraspFrame::from_above(centre_m, yaw_rad, self.home_opening_m);
        self.posture_for(&frame).is_ok()
    }

    /// Whether its domes cannot all face each other within 1° wherever it closes: jaws that turn, as one that is fixed and one on a
    /// joint do, face each other at one opening only.
    #[must_use]
    pub fn domes_tilt(&self) -> bool {
        self.domes_tilt
    }

    /// How far beside the closing axis its domes may face where they touch, radians: 1°, or what domes that tilt bear.
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

    /// How far the worst dome faces beside the closing axis where the hand rests, closed to `opening_m`, radians; `None` where its
    /// fingertips do not get to that opening.
    #[must_use]
    pub fn dome_error_at_home_rad(&self, opening_m: f64) -> Option<f64> {
        let frame = GraspFrame::from_above(self.home_m, self.home_yaw_rad, opening_m);
        let best = match self.posture_for(&frame) {
            Ok(best) | Err(Unreachable { best, .. }) => best,
        };
        best.meets_tips().then_some(best.dome_error_rad)
    }

    /// Tried at openings up to that of rest.
    fn find_domes_tilt(&self) -> bool {
        let step_m = self.home_opening_m / OPENINGS as f64;
        (1..=OPENINGS).any(|step| {
            self.dome_error_at_home_rad(step_m * step as f64)
                .is_some_and(|error_rad| error_rad > POSTURE_DOME_ERROR_MAX_RAD)
        })
    }

    /// Whether it reaches both ends of a turn of a cap where it rests, its fingertips turned no farther than domes that do not tilt
    /// may be: a hand that turns as a whole does not pass one by the other.
    fn turns_both_ways(&self) -> bool {
        [PASS_M, -PASS_M].into_iter().all(|by_m| {
            let frame = GraspFrame {
                tangential_m: [by_m, -by_m],
                ..GraspFrame::from_above(self.home_m, self.home_yaw_rad, CAP_M)
            };
            let dome_error_max_rad = if self.turns_by_wrist {
                self.dome_error_max_rad()
            } else {
                POSTURE_DOME_ERROR_MAX_RAD
            };
            self.posture_within(&frame, dome_error_max_rad).is_ok()
        })
    }

    /// How far open it can be where it rests: at least as far as it rests. A hand whose domes tilt does so the more the wider it is open;
    /// that the arm can follow where it rests is no sign that it can elsewhere, so it opens no farther than that.
    fn find_widest_m(&self) -> f64 {
        if self.domes_tilt {
            return self.home_opening_m;
        }
        let (mut reached_m, mut beyond_m) = (self.home_opening_m, OPEN_MAX_M);
        for _ in 0..HALVINGS {
            let opening_m = (reached_m + beyond_m) / 2.0;
            let frame = GraspFrame::from_above(self.home_m, self.home_yaw_rad, opening_m);
            if self.posture_for(&frame).is_ok() {
                reached_m = opening_m;
            } else {
                beyond_m = opening_m;
            }
        }
        reached_m
    }

    /// The time that the joints of the fingers take from one opening to the next tells how fast the fingers are.
    fn find_finger_speed_m_s(&self) -> f64 {
        let step_m = self.widest_m / OPENINGS as f64;
        let posture = |step: usize| {
            let opening_m = self.widest_m - step_m * step as f64;
            let frame = GraspFrame::from_above(self.home_m, self.home_yaw_rad, opening_m);
            self.posture_for(&frame).ok().map(|found| found.q_rad)
        };
        let mut slowest_m_s = f64::INFINITY;
        for step in 0..OPENINGS {
            if let (Some(from), Some(to)) = (posture(step), posture(step + 1)) {
                for joint in self.arm_joints..self.joint_count {
                    let takes_s =
                        libm::fabs(to[joint] - from[joint]) / self.joints[joint].velocity_max_rad_s;
                    slowest_m_s = slowest_m_s.min(step_m / 2.0 / takes_s);
                }
            }
        }
        slowest_m_s
    }

    /// Finds out whether its domes tilt, how far and how fast it opens, whether it has to turn caps by its wrist, and whether it can
    /// shift and turn a little.
    pub(crate) fn find_abilities(&mut self) {
        self.domes_tilt = self.find_domes_tilt();
        self.widest_m = self.find_widest_m();
        self.finger_speed_m_s = self.find_finger_speed_m_s();
        self.turns_by_wrist = self.turning.wrist.is_some() && !self.turns_both_ways();
        let moves = |axis: Vector3<f64>, sign: f64| {
            self.reaches_beside_home(axis * (sign * LITTLE_M), sign * LITTLE_RAD)
        };
        self.moves_aside = [Vector3::x(), Vector3::y()]
            .into_iter()
            .all(|axis| moves(axis, 1.0) && moves(axis, -1.0));
    }
}
