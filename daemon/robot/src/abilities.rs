//! What a hand can do of what tasks need, tried by the inverse kinematics about where it rests.

use nalgebra::Vector3;

use crate::model::HandModel;
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
        }
    }

    /// Whether it reaches a place beside where it rests, turned against how it rests.
    fn reaches_beside_home(&self, by_m: Vector3<f64>, turned_rad: f64) -> bool {
        let (centre_m, yaw_rad) = (self.home_m + by_m, self.home_yaw_rad + turned_rad);
        let frame = GraspFrame::from_above(centre_m, yaw_rad, self.home_opening_m);
        self.posture_for(&frame).is_ok()
    }

    /// Whether it reaches both ends of a turn of a cap where it rests.
    fn turns_both_ways(&self) -> bool {
        [PASS_M, -PASS_M].into_iter().all(|by_m| {
            let frame = GraspFrame {
                tangential_m: [by_m, -by_m],
                ..GraspFrame::from_above(self.home_m, self.home_yaw_rad, CAP_M)
            };
            self.posture_for(&frame).is_ok()
        })
    }

    /// How far open it can be where it rests: at least as far as it rests.
    fn find_widest_m(&self) -> f64 {
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

    /// Finds out how far and how fast it opens, whether it has to turn caps by its wrist, and whether it can shift and turn a little.
    pub(crate) fn find_abilities(&mut self) {
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
