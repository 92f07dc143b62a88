//! Contact: touch of all grasp sides, closing since then, and carried distance.

use nalgebra::Vector3;
use robot_model::GraspPose;

/// Contact of one grip, from the search to the release.
#[derive(Clone, Copy, Debug, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Contact {
    /// Distance of the fingertips when every side first touched, m.
    touched_gap_m: Option<f64>,
    /// Centre of the grasp when the hand began to carry the object, base frame, m.
    lifted_from_m: Option<Vector3<f64>>,
}

impl Contact {
    /// Creates the contact of an object that the hand already holds.
    pub(super) fn found(centre_m: Vector3<f64>) -> Self {
        Self {
            touched_gap_m: Some(0.0),
            lifted_from_m: Some(centre_m),
        }
    }

    /// Every side touches at this distance of the fingertips, m. Only the first call counts.
    pub(super) fn touch(&mut self, gap_m: f64) {
        self.touched_gap_m.get_or_insert(gap_m);
    }

    /// Begins to carry the object.
    pub(super) fn lift(&mut self, centre_m: Vector3<f64>) {
        self.lifted_from_m = Some(centre_m);
    }

    pub(super) fn all_touched(&self) -> bool {
        self.touched_gap_m.is_some()
    }

    pub(super) fn is_lifted(&self) -> bool {
        self.lifted_from_m.is_some()
    }

    /// Returns the closing since every side touched, m; 0 before.
    pub(super) fn closing_m(&self, gap_m: f64) -> f64 {
        self.touched_gap_m
            .map_or(0.0, |touched_m| touched_m - gap_m)
    }

    /// Returns the distance from the start of the lift, m; 0 before.
    pub(super) fn carried_m(&self, now: &GraspPose) -> f64 {
        self.lifted_from_m
            .map_or(0.0, |from_m| (now.centre_m - from_m).norm())
    }
}
