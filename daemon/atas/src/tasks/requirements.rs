//! Requirements of a task on its goal and hands, derived from its steps.

use super::step::{Motion, Step, Waypoint};
use super::step_sequence::{StepSequence, Task};

/// Requirements of a task.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct TaskRequirements {
    /// The hand visits the object; requires `from_m` and `width_m`.
    pub visits_source: bool,
    /// The object is moved; requires `to_m`.
    pub visits_target: bool,
    /// A turn begins at the grasp, so the hand arrives with displaced fingertips.
    pub grasps_to_turn: bool,
    /// The fingertips move past each other, as for turning a cap.
    pub turns: bool,
    /// The task begins with a release, so the hand may hold an object.
    pub releases_first: bool,
    /// The task begins with an object in hand; `from_m` is its origin, used if placing fails.
    pub starts_with_object: bool,
    /// Both hands take part.
    pub both_hands: bool,
}

impl Task {
    /// Returns the requirements of the task.
    #[must_use]
    pub fn requirements(&self) -> TaskRequirements {
        let track = &self.acting;
        let visits = |waypoints: &[Waypoint]| {
            track
                .iter()
                .filter_map(|step| step.motion.waypoint())
                .any(|waypoint| waypoints.contains(&waypoint))
        };
        let takes_over = track.first().is_some_and(Step::starts_with_object);
        let sources = [
            Waypoint::BeforeSource,
            Waypoint::Around,
            Waypoint::Source,
            Waypoint::Lifted,
        ];
        TaskRequirements {
            visits_source: visits(&sources) || takes_over,
            visits_target: visits(&[Waypoint::OverTarget]) || has_motion(track, Motion::Lower),
            grasps_to_turn: has_motion(track, Motion::Square) && !visits(&[Waypoint::TurnStart]),
            turns: has_motion(track, Motion::Square),
            releases_first: track
                .first()
                .is_some_and(|s| matches!(s.motion, Motion::Open | Motion::LetGo)),
            starts_with_object: takes_over,
            both_hands: self.helping.is_some(),
        }
    }
}

fn has_motion(track: &StepSequence, motion: Motion) -> bool {
    track.iter().any(|step: &Step| step.motion == motion)
}
