//! What a task asks of its goal and of the hands, read off its steps.

use super::{Motion, Site, Step, Task, Track};

/// What must be checked before a task begins.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Demands {
    /// The hand goes to where the object is: `from_m` and `width_m` mean something.
    pub visits_source: bool,
    /// The object goes to another place: `to_m` means something.
    pub visits_target: bool,
    /// A turn begins at the grasp, so the hand comes with its fingertips displaced.
    pub grasps_to_turn: bool,
    /// The task begins by letting go, so the hand may be full.
    pub lets_go_first: bool,
    /// Both hands take part.
    pub both_hands: bool,
}

impl Demands {
    /// Of a task.
    pub(super) fn of(task: &Task) -> Self {
        let track = &task.acting;
        let visits = |sites: &[Site]| {
            track
                .iter()
                .filter_map(|step| step.motion.site())
                .any(|site| sites.contains(&site))
        };
        Self {
            visits_source: visits(&[Site::BeforeSource, Site::Around, Site::Source, Site::Lifted]),
            visits_target: visits(&[Site::OverTarget]) || does(track, Motion::Lower),
            grasps_to_turn: does(track, Motion::Square) && !visits(&[Site::TurnStart]),
            lets_go_first: track
                .first()
                .is_some_and(|s| matches!(s.motion, Motion::Open | Motion::LetGo)),
            both_hands: task.helping.is_some(),
        }
    }
}

fn does(track: &Track, motion: Motion) -> bool {
    track.iter().any(|step: &Step| step.motion == motion)
}
