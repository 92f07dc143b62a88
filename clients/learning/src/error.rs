//! What keeps an environment from going on.

use robot_model::Unreachable;
use sim_backend::{ObjectError, SceneError, WorldFault};

/// Why an environment could not go on.
#[derive(Debug, thiserror::Error)]
pub enum LearningError {
    /// There is nothing to grasp.
    #[error("could not make an environment because it has no object; name at least one")]
    NoObject,
    /// An object cannot be had.
    #[error(transparent)]
    Object(#[from] ObjectError),
    /// The robot's description cannot be loaded.
    #[error("could not load the built-in robot model: {0}")]
    Robot(#[from] robot_model::ModelError),
    /// The scene cannot be set.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// The hand does not get to the object.
    #[error("could not bring the hand to the object: {0}")]
    Reach(Unreachable),
    /// The world came apart.
    #[error(transparent)]
    World(#[from] WorldFault),
    /// An action is not one.
    #[error(
        "could not act because action {index} was {value}, needs a finite number; nothing moved"
    )]
    Action {
        /// Which number.
        index: usize,
        /// What it was.
        value: f32,
    },
    /// No episode has begun, or it has ended.
    #[error("could not step because no episode is under way; call reset first")]
    NotBegun,
}
