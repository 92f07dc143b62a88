//! Errors of learning environments.

use robot_model::Unreachable;
use sim_backend::{ObjectError, SceneError, WorldFault};

/// Error of an environment.
#[derive(Debug, thiserror::Error)]
pub enum LearningError {
    /// Empty list of objects.
    #[error("could not make an environment: the list of objects is empty; name at least one")]
    NoObject,
    /// Object that the hand cannot grasp.
    #[error(
        "could not make an environment: the object {object:?} is {:.0} mm wide, the hand grasps at \
         most {:.0} mm; choose narrower objects", width_m * 1e3, limit_m * 1e3
    )]
    TooWide {
        /// Name of the object.
        object: String,
        /// Its width along the closing axis.
        width_m: f64,
        /// Largest width that the hand grasps.
        limit_m: f64,
    },
    /// Object that cannot be loaded.
    #[error(transparent)]
    Object(#[from] ObjectError),
    /// Robot model that cannot be loaded.
    #[error("could not load the robot: {0}")]
    Robot(#[from] robot_model::ModelError),
    /// Scene that cannot be set up.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// Start pose that the hand cannot reach.
    #[error("could not reach the object: {0}")]
    Reach(Unreachable),
    /// Fault of the simulation.
    #[error(transparent)]
    World(#[from] WorldFault),
    /// Action with a value that is not finite.
    #[error("action rejected: value {index} is {value}, needs a finite number; nothing moved")]
    Action {
        /// Index of the value.
        index: usize,
        /// Rejected value.
        value: f32,
    },
    /// Number of environments or threads out of range.
    #[error("could not make a batch: {what} is {value}, at most {limit}")]
    TooMany {
        /// What is too large.
        what: &'static str,
        /// Its value.
        value: usize,
        /// The largest permitted value.
        limit: usize,
    },
    /// Threads that cannot be started.
    #[error("could not start the threads of a batch: {0}")]
    Threads(#[from] rayon::ThreadPoolBuildError),
    /// No running episode.
    #[error("could not step: no episode is running; call reset first")]
    NotBegun,
}
