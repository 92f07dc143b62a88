//! What the joints bear of a grip: the second witness of what a skin says.
//!
//! A skin whose zero drifts says that the hand presses harder than it does; who relaxes on its word drops the object. The fingers'
//! servos bear what the fingertips press, whatever the skin says: their torques are −Jᵀ·F, F the force on each tip. From them, less
//! what they are without touch (weight and friction of the fingers) and less what the tangential forces make, follows the force
//! along each side's normal, by least squares over the joints of the fingers.
//!
//! A robot that tells no torques (all zero) has no second witness, and nothing is concluded.

use crate::perception::{FingerPercept, Percept};
use crate::settings::Safety;
use nalgebra::Vector3;
use robot_model::{HandModel, HandPose, HandVector, Mover, VIRTUAL_FINGERS};

/// Time constant over which both witnesses are heard, s (ours: longer than a hand's tremble, shorter than any drift).
const FILTER_S: f64 = 0.05;
/// Time constant over which the torques of the free fingers are learnt, s (ours).
const FREE_S: f64 = 0.2;
/// Share of the product of both sides' squares below which their joints are the same, and tell the mean of both (ours).
const SAME_SHARE: f64 = 0.05;
/// How long they must disagree to be doubted, s (ours: longer than an impact).
const DOUBT_S: f64 = 0.1;
/// Share of the tolerated disagreement below which it is none any more (ours).
const AGREED: f64 = 0.5;
/// Share of it beyond which a skin is taken to report too much, or too little (ours: a simulated one reports up to a tenth less than
/// the joints bear, and hardly ever more).
const OVER: f64 = 0.1;
const UNDER: f64 = 0.5;

/// Both witnesses of a hand.
#[derive(Clone, Copy, Debug)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Borne {
    /// Torques of the free fingers, N·m.
    free_n_m: HandVector,
    /// Normal force of each side by the skin, and by the joints, low-passed, N; of both the mean where joints tell no more.
    felt_n: [f64; VIRTUAL_FINGERS],
    borne_n: [f64; VIRTUAL_FINGERS],
    /// How long they have disagreed, s.
    disagreed_s: f64,
}

impl Borne {
    /// Of free fingers that bear nothing.
    pub(super) fn new(model: &HandModel) -> Self {
        Self {
            free_n_m: HandVector::zeros(model.joints().len()),
            felt_n: [0.0; VIRTUAL_FINGERS],
            borne_n: [0.0; VIRTUAL_FINGERS],
            disagreed_s: 0.0,
        }
    }

    /// What the skin reports more than the joints bear, as a factor, at least 1: what lets go of a grip must know.
    pub(super) fn overread(&self, settings: &Safety) -> f64 {
        most_over(&self.felt_n, &self.borne_n, OVER, settings)
    }

    /// What the joints bear more than the skin reports, as a factor, at least 1: what presses must know.
    pub(super) fn underread(&self, settings: &Safety) -> f64 {
        most_over(&self.borne_n, &self.felt_n, UNDER, settings)
    }

    /// What the skin says and what the joints bear, N, if they have disagreed for so long that neither is to be believed.
    pub(super) fn doubt(&self) -> Option<[f64; 2]> {
        let worst = usize::from(self.apart_n(1) > self.apart_n(0));
        (self.disagreed_s > DOUBT_S).then(|| [self.felt_n[worst], self.borne_n[worst]])
    }

    fn apart_n(&self, side: usize) -> f64 {
        (self.felt_n[side] - self.borne_n[side]).abs()
    }

    /// Counts how long one side has disagreed; from then on it must agree better.
    fn judge(&mut self, settings: &Safety, step_s: f64) {
        let allowed = if self.disagreed_s > DOUBT_S {
            AGREED
        } else {
            1.0
        };
        let disagrees = (0..VIRTUAL_FINGERS).any(|side| {
            let least_n = self.felt_n[side].min(self.borne_n[side]).max(0.0);
            self.apart_n(side) > allowed * tolerated_n(least_n, settings)
        });
        self.disagreed_s = if disagrees {
            self.disagreed_s + step_s
        } else {
            0.0
        };
    }

    /// Hears both: where the hand is and what its servos bear, N·m, and what the fingertips feel. Fingers that neither touch nor
    /// grip are free.
    pub(super) fn hear(
        &mut self,
        model: &HandModel,
        (pose, effort_n_m): (&HandPose, &HandVector),
        percept: &Percept,
        grips: bool,
        settings: &Safety,
        step_s: f64,
    ) {
        let touches = percept.virtual_fingers.iter().any(|side| side.in_contact);
        if !touches && !grips {
            let share = step_s / (FREE_S + step_s);
            let learnt = |free, now| free + (now - free) * share;
            self.free_n_m = self.free_n_m.zip_map(effort_n_m, learnt);
            (self.felt_n, self.borne_n, self.disagreed_s) = Default::default();
            return;
        }
        let loaded_n_m = effort_n_m.zip_map(&self.free_n_m, |now, free| now - free);
        let felt_n = percept.virtual_fingers.each_ref().map(|felt| felt.normal_n);
        let (felt_n, borne_n) = match borne_n(model, pose, &loaded_n_m, percept) {
            Bears::Each(borne_n) => (felt_n, borne_n),
            // The side that touches first pushes the object alone, and the joints cannot tell which side that is.
            Bears::Mean(borne_n) => {
                let felt_n = felt_n.iter().sum::<f64>() / VIRTUAL_FINGERS as f64;
                ([felt_n; VIRTUAL_FINGERS], [borne_n; VIRTUAL_FINGERS])
            }
        };
        let share = step_s / (FILTER_S + step_s);
        for side in 0..VIRTUAL_FINGERS {
            self.felt_n[side] += (felt_n[side] - self.felt_n[side]) * share;
            self.borne_n[side] += (borne_n[side] - self.borne_n[side]) * share;
        }
        self.judge(settings, step_s);
    }
}

/// How far one witness exceeds the other and a share of what is tolerated, as a factor, on the side where it is most; at least 1.
fn most_over(
    ones_n: &[f64; VIRTUAL_FINGERS],
    others_n: &[f64; VIRTUAL_FINGERS],
    share: f64,
    settings: &Safety,
) -> f64 {
    ones_n
        .iter()
        .zip(others_n)
        .fold(1.0, |most, (one_n, other_n)| {
            let other_n = other_n.max(0.0);
            let factor = one_n / (other_n + share * tolerated_n(other_n, settings));
            if factor > most { factor } else { most }
        })
}

/// By how much both may disagree about a force, N.
fn tolerated_n(force_n: f64, settings: &Safety) -> f64 {
    settings.disagree_n + settings.disagree_share * force_n
}

/// What the joints tell, N.
enum Bears {
    /// The normal force of each side.
    Each([f64; VIRTUAL_FINGERS]),
    /// The mean of both: the same joints move both.
    Mean(f64),
}

/// Normal force of the sides by the torques that load brings to the joints.
fn borne_n(
    model: &HandModel,
    pose: &HandPose,
    loaded_n_m: &HandVector,
    percept: &Percept,
) -> Bears {
    let zeros = HandVector::zeros(loaded_n_m.len());
    // Torques that one newton along each side's normal makes, and what is left when the tangential forces are answered.
    let mut unit_n_m = [zeros; VIRTUAL_FINGERS];
    let mut rest_n_m = *loaded_n_m;
    for finger in 0..model.finger_count() {
        let (side, felt) = (model.virtual_finger(finger), &percept.fingers[finger]);
        let base_from_tip = pose.base_from_tip()[finger].rotation;
        let inward = -(base_from_tip * felt.patch_normal);
        let tangential_n = base_from_tip * tangential_n(felt);
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
    let [first, second] = &unit_n_m;
    let (a, b, c) = (dot(first, first), dot(first, second), dot(second, second));
    let (p, q) = (dot(first, &rest_n_m), dot(second, &rest_n_m));
    let determinant = a * c - b * b;
    if determinant > SAME_SHARE * a * c {
        Bears::Each([(p * c - q * b) / determinant, (q * a - p * b) / determinant])
    } else if a + 2.0 * b + c > 0.0 {
        Bears::Mean((p + q) / (a + 2.0 * b + c))
    } else {
        Bears::Mean(0.0)
    }
}

/// Force of the object on a tip less its part along the normal, tip frame, N.
fn tangential_n(felt: &FingerPercept) -> Vector3<f64> {
    felt.force_tip_n - felt.patch_normal * felt.force_tip_n.dot(&felt.patch_normal)
}

/// Share of its side's force that a fingertip presses with.
fn share_of_side(model: &HandModel, percept: &Percept, finger: usize) -> f64 {
    let side = model.virtual_finger(finger);
    let count = model.fingers_of(side).count() as f64;
    let whole_n = percept.virtual_fingers[side].normal_n;
    if count > 1.0 && whole_n > 0.0 {
        percept.fingers[finger].normal_n / whole_n
    } else {
        1.0 / count
    }
}
