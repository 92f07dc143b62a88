//! Learning tasks and their scenes.

use robot_model::HandModel;
use sim_backend::{GraspHint, Object, Scene};

/// Learning task.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Task {
    /// Grasp the object between the fingertips, lift it by 40 mm, hold it for 0.5 s.
    Grasp,
    /// Carry the object to a given target, place it, release it.
    PickPlace,
}

impl Task {
    /// Built-in objects that two fingertips can hold without crushing: the default objects, as far
    /// as the hand opens wide enough.
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

    /// Makes a random variation of the scene around an object in front of a hand.
    pub(crate) fn scene(self, hand: &HandModel, object: Object, seed: u64) -> Scene {
        match self {
            Self::Grasp => Scene::grasp(object, hand.side()),
            Self::PickPlace => Scene::pick_place(object, hand.side()),
        }
        .moved_to_hand(hand)
        .varied(seed)
    }

    /// Returns the nominal target of the object; `None` if the task has none.
    pub(crate) fn place(self, scene: &Scene) -> Option<GraspHint> {
        scene.place.filter(|_| self == Self::PickPlace)
    }
}
