//! The tasks that can be learnt: their scenes and what a policy is told of them.

use robot_model::Side;
use sim_backend::{GraspHint, Object, Scene};

/// The hand that acts.
pub(crate) const SIDE: Side = Side::Right;

/// A task.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Task {
    /// Grasp what stands between the fingers, lift it by 40 mm, hold it for half a second.
    Grasp,
    /// Carry it to the place that is told, set it down, let go.
    PickPlace,
}

impl Task {
    /// The built-in objects that two fingers can hold without crushing them.
    pub const OBJECTS: [&'static str; 6] = [
        "wood",
        "slippery-200",
        "slippery-50",
        "paper-box",
        "sponge",
        "bottle",
    ];

    /// Longest episode, s (ours: three times what a deliberate policy takes).
    #[must_use]
    pub fn limit_s(self) -> f64 {
        match self {
            Self::Grasp => 6.0,
            Self::PickPlace => 12.0,
        }
    }

    /// A member of the family around an object.
    pub(crate) fn scene(self, object: Object, seed: u64) -> Scene {
        match self {
            Self::Grasp => Scene::grasp(object, SIDE),
            Self::PickPlace => Scene::pick_place(object, SIDE),
        }
        .varied(seed)
    }

    /// Where the object shall go, as it is told; `None` if it has no place.
    pub(crate) fn place(self, scene: &Scene) -> Option<GraspHint> {
        scene.place.filter(|_| self == Self::PickPlace)
    }
}
