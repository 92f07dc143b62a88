//! Alignment of opposing fingertips with the closing axis at the rest pose, as a function of the
//! opening.

use robot_model::HandModel;
use serde_json::{Value, json};

/// Step between tested openings, m (design choice).
const STEP_M: f64 = 0.001;
const TOLD: usize = 10;

/// Largest angle between a fingertip axis and the closing axis, per opening.
pub(super) struct Facing {
    /// Reachable openings, m, each with the angle of the worst fingertip, rad.
    at: Vec<(f64, f64)>,
    bears_rad: f64,
    tilts: bool,
}

impl Facing {
    pub(super) fn of(hand: &HandModel) -> Self {
        let steps = (hand.widest_m() / STEP_M) as usize;
        let openings_m = (1..=steps).map(|step| step as f64 * STEP_M);
        let at = openings_m
            .filter_map(|opening_m| Some((opening_m, hand.dome_error_at_home_rad(opening_m)?)))
            .collect();
        Self {
            at,
            bears_rad: hand.dome_error_max_rad(),
            tilts: hand.domes_tilt(),
        }
    }

    /// Returns the smallest and largest opening with an acceptable angle, m.
    fn grasps_m(&self) -> Option<[f64; 2]> {
        let mut bears = self.at.iter().filter(|(_, rad)| *rad <= self.bears_rad);
        let (least_m, _) = bears.next()?;
        Some([*least_m, bears.next_back().map_or(*least_m, |(m, _)| *m)])
    }

    pub(super) fn lines(&self) -> Vec<String> {
        let worst_rad = self.at.iter().fold(0.0_f64, |worst, at| worst.max(at.1));
        if !self.tilts {
            let worst = worst_rad.to_degrees();
            return vec![format!(
                "its fingertips face each other within {worst:.1}° at every opening"
            )];
        }
        let told = self
            .at
            .iter()
            .filter(|(opening_m, _)| ((opening_m / STEP_M).round() as usize).is_multiple_of(TOLD));
        let told: Vec<String> = told
            .map(|(opening_m, rad)| format!("{:.0} mm {:.0}°", opening_m * 1e3, rad.to_degrees()))
            .collect();
        let bears = self.bears_rad.to_degrees();
        let grasps = self.grasps_m().map_or_else(
            || "so it can grasp nothing".to_owned(),
            |[least_m, most_m]| {
                let [least, most] = [least_m, most_m].map(|m| m * 1e3);
                format!("so it grasps what is {least:.0} to {most:.0} mm wide")
            },
        );
        vec![
            format!(
                "its fingertips tilt as it closes; closed to so far, one faces so much aside: {}",
                told.join(", ")
            ),
            format!("where they touch they bear {bears:.1}°, {grasps}"),
        ]
    }

    pub(super) fn json(&self) -> Value {
        let at = self.at.iter().map(
            |(opening_m, error_rad)| json!({ "opening_m": opening_m, "error_rad": error_rad }),
        );
        json!({
            "tilts": self.tilts,
            "bears_rad": self.bears_rad,
            "grasps_m": self.grasps_m(),
            "at": at.collect::<Vec<_>>(),
        })
    }
}
