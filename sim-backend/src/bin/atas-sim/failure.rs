//! Errors that end the process, and its exit codes.

use robot_model::ModelError;
use shm_bus::BusError;
use sim_backend::{ObjectError, SceneError, WorldFault};

#[derive(Debug, thiserror::Error)]
pub(crate) enum Failure {
    #[error(transparent)]
    Object(#[from] ObjectError),
    #[error(transparent)]
    Scene(#[from] SceneError),
    #[error("could not set the scene because {0}")]
    Usage(&'static str),
    #[error(transparent)]
    Robot(#[from] ModelError),
    #[error(transparent)]
    Bus(#[from] BusError),
    #[error(transparent)]
    World(#[from] WorldFault),
    #[error(
        "could not use the preset because {why}, needs one of {names} or a TOML file with every number of a preset; correct --preset"
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
        "could not host the course because it had {objects} objects and {buses} buses, needs one of each for every robot; correct --object or --bus"
    )]
    Buses { objects: usize, buses: usize },
    #[error(transparent)]
    Ride(#[from] sim_backend::OutOfRange),
    #[error("could not write to standard output because of: {0}")]
    Output(std::io::Error),
    #[error("could not write manual pages into {folder:?} because of: {source}")]
    Manual {
        folder: std::path::PathBuf,
        source: std::io::Error,
    },
    #[error("could not watch for SIGINT and SIGTERM because of: {0}")]
    Signals(std::io::Error),
}

impl Failure {
    /// Table of exit codes for `--help`.
    pub(crate) const EXIT_CODES: &str = "\
Exit codes:
  0  ended as asked: by --duration, after the last trial or the course, by SIGINT or SIGTERM
  1  the world could not be simulated any further, or the output not written; a closed pipe is no failure
  2  wrong usage: command line, object, scene, fault, robot, preset, team or course
  3  the bus could not be used
Log: standard error, filtered by RUST_LOG (default info). With --format json an error is one JSON object there: {error, exit}.";

    /// Exit code for failed output.
    pub(crate) const UNWRITTEN: u8 = 1;

    pub(crate) fn exit_code(&self) -> u8 {
        match self {
            Self::Output(_) => Self::UNWRITTEN,
            Self::World(_) | Self::Ride(_) | Self::Signals(_) | Self::Manual { .. } => 1,
            Self::Object(_) | Self::Scene(_) | Self::Usage(_) | Self::Robot(_) => 2,
            Self::Course(_) | Self::Buses { .. } => 2,
            Self::Preset { .. } | Self::Field(_) | Self::Team(_) | Self::Swarm(_) => 2,
            Self::Bus(_) => 3,
        }
    }
}
