//! Errors that end the process, and its exit codes.

use atas_process::exit::Exit;
use robot_model::ModelError;
use shm_bus::BusError;
use sim_backend::engine::EngineError;
use sim_backend::{ObjectError, SceneError, SensorModelError, WorldFault};

#[derive(Debug, thiserror::Error)]
pub(crate) enum Failure {
    #[error(transparent)]
    Object(#[from] ObjectError),
    #[error(transparent)]
    SensorModel(#[from] SensorModelError),
    #[error(transparent)]
    Scene(#[from] SceneError),
    #[error("scene rejected: {0}")]
    Usage(&'static str),
    #[error(transparent)]
    Robot(#[from] ModelError),
    #[error(transparent)]
    Bus(#[from] BusError),
    #[error(transparent)]
    World(#[from] WorldFault),
    #[error(transparent)]
    Engine(#[from] EngineError),
    #[error(
        "preset rejected: {why}, needs one of {names} or a TOML file of a preset; correct --preset"
    )]
    Preset { why: String, names: String },
    #[error(transparent)]
    Field(#[from] field::PresetError),
    #[error(transparent)]
    Team(#[from] field::TeamSizeError),
    #[error(transparent)]
    Swarm(#[from] sim_backend::swarm::SwarmError),
    #[error(transparent)]
    Course(#[from] sim_backend::course::CourseError),
    #[error(
        "course rejected: {objects} objects and {buses} buses, needs one of each per robot; \
         correct --object or --bus"
    )]
    Buses { objects: usize, buses: usize },
    #[error(transparent)]
    BaseMotion(#[from] sim_backend::BaseMotionError),
    #[error("could not write to standard output: {0}")]
    Output(std::io::Error),
    #[error("could not write manual pages into {folder:?}: {source}")]
    Manual {
        folder: std::path::PathBuf,
        source: std::io::Error,
    },
    #[error("could not install the handlers of SIGINT and SIGTERM: {0}")]
    Signals(std::io::Error),
}

impl Failure {
    /// Notes at the end of `--help`.
    pub(crate) const NOTES: &str = "\
Log: standard error, filtered by RUST_LOG (default info). --format json: an error is one JSON object there, {error, exit}.";

    pub(crate) fn exit_code(&self) -> Exit {
        match self {
            Self::Output(_) | Self::World(_) | Self::BaseMotion(_) => Exit::Failed,
            Self::Signals(_) | Self::Manual { .. } => Exit::Failed,
            Self::Engine(_)
            | Self::Object(_)
            | Self::Scene(_)
            | Self::Usage(_)
            | Self::Robot(_) => Exit::Usage,
            Self::SensorModel(_) | Self::Course(_) | Self::Buses { .. } => Exit::Usage,
            Self::Preset { .. } | Self::Field(_) | Self::Team(_) | Self::Swarm(_) => Exit::Usage,
            Self::Bus(error) if error.is_in_use() => Exit::InUse,
            Self::Bus(_) => Exit::Bus,
        }
    }
}
