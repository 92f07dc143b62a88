//! Torque-force check: compares the tactile normal force with the force estimated from joint
//! torques.
//!
//! Detects zero drift of a skin, which would make the hand drop or crush its object. The fingertip
//! forces F load the servos with −Jᵀ·F. The check subtracts free-finger torques (weight, friction)
//! and tangential forces. Least squares over the finger joints gives the normal force per grasp
//! side. Without torque readings (all zero), the check is inactive.

use crate::filter::{Dwell, low_pass};
use crate::perception::{ContactPercept, Percept};
use crate::settings::Safety;
use nalgebra::Vector3;
use robot_model::{GraspSide, HandModel, HandPose, HandVector, Mover, PerSide};

/// Filter time constant of both forces, s (design choice: longer than hand tremor, shorter than
/// drift).
const FILTER_S: f64 = 0.05;
/// Filter time constant of the free-finger torques, s (design choice).
const FREE_FILTER_S: f64 = 0.2;
/// Time of closing towards contact after which torques are no longer learnt as free, s. A skin that
/// drifts may not feel the object that the fingers squeeze. Design choice: joint friction has
/// shown, and the fingers have moved by 0.6 mm.
const CLOSING_LEARN_S: f64 = 0.3;
/// Normalised determinant below which only the mean of both sides is observable (design choice).
const DEPENDENT_SHARE: f64 = 0.05;
/// Duration of a disagreement before it is reported, s (design choice: longer than an impact).
const MISMATCH_S: f64 = 0.1;
/// Share of the tolerated disagreement below which both forces agree again (design choice).
const AGREEMENT_SHARE: f64 = 0.5;
/// Dead bands of the two force ratios, as shares of the tolerated disagreement (design choice). A
/// simulated skin reads up to a tenth below the torque-estimated force, rarely above it.
const TACTILE_OVER_SHARE: f64 = 0.1;
const TORQUE_OVER_SHARE: f64 = 0.5;

#[derive(Clone, Copy, Debug)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct TorqueForceCheck {
    /// Free-finger torques, N·m or N.
    free_n_m: HandVector,
    /// Filtered tactile and torque-estimated normal force per grasp side, N. Both sides hold the
    /// mean if only that is known.
    tactile_n: PerSide<f64>,
    torque_n: PerSide<f64>,
    /// Filtered normal force per grasp side that masked elements may carry unseen, N.
    unseen_n: PerSide<f64>,
    /// Duration of the present disagreement.
    disagreement: Dwell,
}

impl TorqueForceCheck {
    /// Creates a check for free fingers.
    pub(super) fn new(model: &HandModel) -> Self {
        Self {
            free_n_m: HandVector::zeros(model.joints().len()),
            tactile_n: PerSide::repeat(0.0),
            torque_n: PerSide::repeat(0.0),
            unseen_n: PerSide::repeat(0.0),
            disagreement: Dwell::default(),
        }
    }

    /// Ratio of tactile to torque-estimated force, ≥ 1. Limits grip relaxation.
    pub(super) fn tactile_over_torque(&self, settings: &Safety) -> f64 {
        max_ratio(
            &self.tactile_n,
            &self.torque_n,
            TACTILE_OVER_SHARE,
            settings,
        )
    }

    /// Ratio of torque-estimated to tactile force, ≥ 1. Limits pressing.
    pub(super) fn torque_over_tactile(&self, settings: &Safety) -> f64 {
        max_ratio(&self.torque_n, &self.tactile_n, TORQUE_OVER_SHARE, settings)
    }

    /// Returns tactile and torque-estimated force, N, after a disagreement of `MISMATCH_S`.
    pub(super) fn mismatch(&self) -> Option<[f64; 2]> {
        let [first_n, second_n] = GraspSide::BOTH.map(|side| self.difference_n(side));
        let worst = if second_n > first_n {
            GraspSide::Second
        } else {
            GraspSide::First
        };
        (self.disagreement.seconds() > MISMATCH_S)
            .then(|| [self.tactile_n[worst], self.torque_n[worst]])
    }

    /// Returns the difference of both forces, less what masked elements may carry.
    fn difference_n(&self, side: GraspSide) -> f64 {
        let more_n = self.torque_n[side] - self.tactile_n[side];
        if more_n > 0.0 {
            (more_n - self.unseen_n[side]).max(0.0)
        } else {
            -more_n
        }
    }

    /// Updates the disagreement timer. The tolerance is stricter once a mismatch is reported.
    fn update_timer(&mut self, settings: &Safety, step_s: f64) {
        let allowed = if self.disagreement.seconds() > MISMATCH_S {
            AGREEMENT_SHARE
        } else {
            1.0
        };
        let disagrees = GraspSide::BOTH.into_iter().any(|side| {
            let least_n = self.tactile_n[side].min(self.torque_n[side]).max(0.0);
            self.difference_n(side) > allowed * tolerated_n(least_n, settings)
        });
        self.disagreement.update(disagrees, step_s);
    }

    /// Learns the torques, N·m or N, of fingers that are free.
    pub(super) fn learn_free(&mut self, effort: &HandVector, step_s: f64) {
        let learnt = |free, now| low_pass(free, now, step_s, FREE_FILTER_S);
        self.free_n_m = self.free_n_m.zip_map(effort, learnt);
        (self.tactile_n, self.torque_n, self.unseen_n) = Default::default();
        self.disagreement = Dwell::default();
    }

    /// Updates the check from hand pose, servo torques, N·m or N, and percept. Fingers without
    /// contact or grip are free, unless they have been closing towards contact for
    /// `CLOSING_LEARN_S`.
    pub(super) fn update(
        &mut self,
        model: &HandModel,
        (pose, effort): (&HandPose, &HandVector),
        percept: &Percept,
        (grips, closing_s): (bool, f64),
        settings: &Safety,
        step_s: f64,
    ) {
        let touches = percept.sides.iter().any(|side| side.in_contact);
        if !touches && !grips && closing_s < CLOSING_LEARN_S {
            return self.learn_free(effort, step_s);
        }
        let loaded_n_m = effort.zip_map(&self.free_n_m, |now, free| now - free);
        let felt_n = percept.sides.each_ref().map(|measured| measured.normal_n);
        let unseen_n = percept.sides.each_ref().map(unseen_n);
        let (felt_n, unseen_n, borne_n) = match joint_force_n(model, pose, &loaded_n_m, percept) {
            JointForce::PerSide(borne_n) => (felt_n, unseen_n, borne_n),
            // Until both sides touch, one side pushes the object; the joints cannot distinguish
            // which.
            JointForce::Mean(borne_n) => {
                let [felt_n, unseen_n] = [felt_n.mean(), unseen_n.mean()];
                let repeat = PerSide::repeat;
                (repeat(felt_n), repeat(unseen_n), repeat(borne_n))
            }
        };
        for side in GraspSide::BOTH {
            self.tactile_n[side] = low_pass(self.tactile_n[side], felt_n[side], step_s, FILTER_S);
            self.torque_n[side] = low_pass(self.torque_n[side], borne_n[side], step_s, FILTER_S);
            self.unseen_n[side] = low_pass(self.unseen_n[side], unseen_n[side], step_s, FILTER_S);
        }
        self.update_timer(settings, step_s);
    }
}

/// Returns the largest ratio of one force to the other plus its dead band, over both sides, ≥ 1.
fn max_ratio(ones_n: &PerSide<f64>, others_n: &PerSide<f64>, share: f64, settings: &Safety) -> f64 {
    ones_n
        .iter()
        .zip(others_n)
        .fold(1.0, |most, (one_n, other_n)| {
            let other_n = other_n.max(0.0);
            let factor = one_n / (other_n + share * tolerated_n(other_n, settings));
            if factor > most { factor } else { most }
        })
}

/// Returns the normal force that masked elements carry if the pressure keeps its shape, N.
fn unseen_n(measured: &ContactPercept) -> f64 {
    let share = measured.masked_share;
    (measured.normal_n * share / (1.0 - share)).max(0.0)
}

/// Returns the tolerated disagreement, N.
fn tolerated_n(force_n: f64, settings: &Safety) -> f64 {
    settings.force_mismatch_n + settings.force_mismatch_share * force_n
}

/// Normal force estimated from joint torques, N.
enum JointForce {
    /// Force of each grasp side.
    PerSide(PerSide<f64>),
    /// Mean of both sides, if the same joints move both.
    Mean(f64),
}

/// Estimates the normal force per side from the torques due to load.
fn joint_force_n(
    model: &HandModel,
    pose: &HandPose,
    loaded_n_m: &HandVector,
    percept: &Percept,
) -> JointForce {
    let zeros = HandVector::zeros(loaded_n_m.len());
    // Torques per newton of normal force per side, and residual torques without tangential forces.
    let mut unit_n_m = PerSide::repeat(zeros);
    let mut rest_n_m = *loaded_n_m;
    for finger in 0..model.fingertip_count() {
        let (side, measured) = (model.grasp_side(finger), &percept.fingertips[finger]);
        let base_from_tip = pose.base_from_tip()[finger].rotation;
        let inward = -(base_from_tip * measured.patch_normal);
        let tangential_n = base_from_tip * tangential_n(measured);
        let along = inward * share_of_side(model, percept, finger);
        let own = |mover: &&Mover| mover.joint >= model.arm_joints().end;
        for mover in model.movers(finger).filter(own) {
            let moved = pose.tip_moved_by(finger, mover);
            unit_n_m[side][mover.joint] -= moved.dot(&along);
            rest_n_m[mover.joint] += moved.dot(&tangential_n);
        }
    }
    let dot = |a: &HandVector, b: &HandVector| -> f64 {
        a.iter().zip(b.iter()).map(|(a, b)| a * b).sum()
    };
    let [first, second] = &unit_n_m.into_array();
    let (a, b, c) = (dot(first, first), dot(first, second), dot(second, second));
    let (p, q) = (dot(first, &rest_n_m), dot(second, &rest_n_m));
    let determinant = a * c - b * b;
    if determinant > DEPENDENT_SHARE * a * c {
        JointForce::PerSide(PerSide::new(
            (p * c - q * b) / determinant,
            (q * a - p * b) / determinant,
        ))
    } else if a + 2.0 * b + c > 0.0 {
        JointForce::Mean((p + q) / (a + 2.0 * b + c))
    } else {
        JointForce::Mean(0.0)
    }
}

/// Tangential part of the force on a fingertip, tip frame, N.
fn tangential_n(measured: &ContactPercept) -> Vector3<f64> {
    measured.force_tip_n - measured.patch_normal * measured.force_tip_n.dot(&measured.patch_normal)
}

/// Share of a fingertip in the force of its grasp side.
fn share_of_side(model: &HandModel, percept: &Percept, finger: usize) -> f64 {
    let side = model.grasp_side(finger);
    let count = model.fingertips_of(side).count() as f64;
    let whole_n = percept.sides[side].normal_n;
    if count > 1.0 && whole_n > 0.0 {
        percept.fingertips[finger].normal_n / whole_n
    } else {
        1.0 / count
    }
}
