//! How the grip fared while the base drove.

use serde::{Deserialize, Serialize};
use shm_schemas::WorldTruth;

use super::SIDE;
use crate::ride::Ride;

/// The base's accelerations on a drive.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Shake {
    /// Largest horizontal acceleration of the base's middle, m/s².
    pub horizontal_m_s2: f64,
    /// Largest vertical one, m/s².
    pub vertical_m_s2: f64,
}

/// What is measured from the first step of a drive to the last.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct DriveFigures {
    /// How long it took, s.
    pub took_s: f64,
    /// True normal force of the weaker finger when it began, N; its least and its most on the way.
    pub began_n: f64,
    /// See `began_n`.
    pub least_n: f64,
    /// See `began_n`.
    pub most_n: f64,
    /// True slip in the hand that was added on the way, m.
    pub slip_m: f64,
    /// What the base did.
    pub shake: Shake,
}

/// A drive under way.
#[derive(Clone, Copy, Debug)]
pub(super) struct Drive {
    figures: DriveFigures,
    slip_before_m: f64,
    ticks: u64,
}

impl Drive {
    /// A drive that begins with the world as it is.
    pub(super) fn begin(truth: &WorldTruth) -> Self {
        let pressed_n = weaker_n(truth);
        Self {
            figures: DriveFigures {
                began_n: pressed_n,
                least_n: pressed_n,
                most_n: pressed_n,
                ..DriveFigures::default()
            },
            slip_before_m: truth.objects[0].slip_in_hand_m,
            ticks: 0,
        }
    }

    /// Takes in one tick.
    pub(super) fn watch(&mut self, truth: &WorldTruth, ride: &Ride) {
        self.ticks += 1;
        let (figures, pressed_n) = (&mut self.figures, weaker_n(truth));
        figures.least_n = figures.least_n.min(pressed_n);
        figures.most_n = figures.most_n.max(pressed_n);
        figures.slip_m = (truth.objects[0].slip_in_hand_m - self.slip_before_m).max(0.0);
        let shake = &mut figures.shake;
        let aside = ride.speed_m_s * ride.turn_rad_s;
        let horizontal = length(ride.acceleration_m_s2, aside);
        shake.horizontal_m_s2 = shake.horizontal_m_s2.max(horizontal);
        shake.vertical_m_s2 = shake.vertical_m_s2.max(ride.heave_m_s2.abs());
    }

    pub(super) fn figures(&self) -> DriveFigures {
        DriveFigures {
            took_s: self.ticks as f64 * 1e-3,
            ..self.figures
        }
    }
}

/// √(a² + b²), from operations that every machine rounds alike.
fn length(a: f64, b: f64) -> f64 {
    (a * a + b * b).sqrt()
}

/// The normal force of the weaker finger, N.
fn weaker_n(truth: &WorldTruth) -> f64 {
    let fingers = &truth.normal_n[SIDE.index()][..robot_model::VIRTUAL_FINGERS];
    fingers.iter().copied().fold(f64::INFINITY, f64::min)
}
