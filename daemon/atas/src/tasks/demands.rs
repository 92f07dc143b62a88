//! What a task asks of its goal and of the hands, read off its steps.

use super::step::{Motion, Step, Waypoint};
use super::track::{Task, Track};

/// What must be checked before a task begins.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Demands {
    /// The hand goes to where the object is: `from_m` and `width_m` mean something.
    pub visits_source: bool,
    /// The object goes to another place: `to_m` means something.
    pub visits_target: bool,
    /// A turn begins at the grasp, so the hand comes with its fingertips displaced.
    pub grasps_to_turn: bool,
    /// The fingertips pass each other, as turning a cap needs.
    pub turns: bool,
    /// The task begins by letting go, so the hand may be full.
    pub lets_go_first: bool,
    /// The task begins by moving what the hand holds: the hand must be full, and `from_m` is where that came from and where
    /// it goes back to if it finds no place.
    pub takes_over: bool,
    /// Both hands take part.
    pub both_hands: bool,
}

impl Task {
    /// What the task asks of its goal.
    #[must_use]
    pub fn demands(&self) -> Demands {
        let track = &self.acting;
        let visits = |waypoints: &[Waypoint]| {
            track
                .iter()
                .filter_map(|step| step.motion.waypoint())
                .any(|waypoint| waypoints.contains(&waypoint))
        };
        let takes_over = track.first().is_some_and(Step::takes_over);
        let sources = [
            Waypoint::BeforeSource,
            Waypoint::Around,
            Waypoint::Source,
            Waypoint::Lifted,
        ];
        Demands {
            visits_source: visits(&sources) || takes_over,
            visits_target: visits(&[Waypoint::OverTarget]) || does(track, Motion::Lower),
            grasps_to_turn: does(track, Motion::Square) && !visits(&[Waypoint::TurnStart]),
            turns: does(track, Motion::Square),
            lets_go_first: track
                .first()
                .is_some_and(|s| matches!(s.motion, Motion::Open | Motion::LetGo)),
            takes_over,
            both_hands: self.helping.is_some(),
        }
    }
}

fn does(track: &Track, motion: Motion) -> bool {
    track.iter().any(|step: &Step| step.motion == motion)
}
