//! Alignment of opposing fingertips with the closing axis at the rest pose, as a function of the
//! opening.

use robot_model::HandModel;
use serde_json::{Value, json};

/// Step between tested openings, m (design choice).
const STEP_M: f64 = 0.001;
const PRINT_INTERVAL: usize = 10;

/// Largest angle between a fingertip axis and the closing axis, per opening.
pub(super) struct Facing {
    /// Reachable openings, m, each with the angle of the worst fingertip, rad.
    error_by_opening: Vec<(f64, f64)>,
    limit_rad: f64,
    tilts: bool,
}

impl Facing {
    pub(super) fn from_hand(hand: &HandModel) -> Self {
        let steps = (hand.max_opening_m() / STEP_M) as usize;
        let openings_m = (1..=steps).map(|step| step as f64 * STEP_M);
        let at = openings_m
            .filter_map(|opening_m| Some((opening_m, hand.dome_error_at_home_rad(opening_m)?)))
            .collect();
        Self {
            error_by_opening: at,
            limit_rad: hand.dome_error_max_rad(),
            tilts: hand.domes_tilt(),
        }
    }

    /// Returns the smallest and largest opening with an acceptable angle, m.
    fn graspable_m(&self) -> Option<[f64; 2]> {
        let mut tolerated = self
            .error_by_opening
            .iter()
            .filter(|(_, rad)| *rad <= self.limit_rad);
        let (least_m, _) = tolerated.next()?;
        Some([
            *least_m,
            tolerated.next_back().map_or(*least_m, |(m, _)| *m),
        ])
    }

    pub(super) fn lines(&self) -> Vec<String> {
        let worst_rad = self
            .error_by_opening
            .iter()
            .fold(0.0_f64, |worst, at| worst.max(at.1));
        if !self.tilts {
            let worst = worst_rad.to_degrees();
            return vec![format!(
                "opposing fingertips are parallel within {worst:.1}° at every opening"
            )];
        }
        let reported = self.error_by_opening.iter().filter(|(opening_m, _)| {
            ((opening_m / STEP_M).round() as usize).is_multiple_of(PRINT_INTERVAL)
        });
        let reported: Vec<String> = reported
            .map(|(opening_m, rad)| format!("{:.0} mm {:.0}°", opening_m * 1e3, rad.to_degrees()))
            .collect();
        let tolerated = self.limit_rad.to_degrees();
        let grasps = self.graspable_m().map_or_else(
            || "no grasp is possible".to_owned(),
            |[least_m, most_m]| {
                let [least, most] = [least_m, most_m].map(|m| m * 1e3);
                format!("graspable widths: {least:.0} to {most:.0} mm")
            },
        );
        vec![
            format!(
                "fingertips tilt while closing; worst angle to the closing axis per opening: {}",
                reported.join(", ")
            ),
            format!("largest angle allowed in contact: {tolerated:.1}°; {grasps}"),
        ]
    }

    pub(super) fn json(&self) -> Value {
        let at = self.error_by_opening.iter().map(
            |(opening_m, error_rad)| json!({ "opening_m": opening_m, "error_rad": error_rad }),
        );
        json!({
            "tilts": self.tilts,
            "bears_rad": self.limit_rad,
            "grasps_m": self.graspable_m(),
            "at": at.collect::<Vec<_>>(),
        })
    }
}
