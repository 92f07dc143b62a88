//! Learning tasks and their scenes.

use robot_model::HandSide;
use sim_backend::{GraspHint, Object, Scene};

pub(crate) const SIDE: HandSide = HandSide::Right;

/// Learning task.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Task {
    /// Grasp the object between the fingertips, lift it by 40 mm, hold it for 0.5 s.
    Grasp,
    /// Carry the object to a given target, place it, release it.
    PickPlace,
}

impl Task {
    /// Built-in objects that two fingertips can hold without crushing.
    pub const OBJECTS: [&'static str; 6] = [
        "wood",
        "slippery-200",
        "slippery-50",
        "paper-box",
        "sponge",
        "bottle",
    ];

    /// Returns the time limit of an episode, s (design choice: three times that of a careful
    /// policy).
    #[must_use]
    pub fn limit_s(self) -> f64 {
        match self {
            Self::Grasp => 6.0,
            Self::PickPlace => 12.0,
        }
    }

    /// Makes a random variation of the scene around an object.
    pub(crate) fn scene(self, object: Object, seed: u64) -> Scene {
        match self {
            Self::Grasp => Scene::grasp(object, SIDE),
            Self::PickPlace => Scene::pick_place(object, SIDE),
        }
        .varied(seed)
    }

    /// Returns the nominal target of the object; `None` if the task has none.
    pub(crate) fn place(self, scene: &Scene) -> Option<GraspHint> {
        scene.place.filter(|_| self == Self::PickPlace)
    }
}
