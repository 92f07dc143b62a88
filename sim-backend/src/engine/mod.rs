//! Physics engines in a process of their own.
//!
//! ```text
//!  World ── Begin{EngineScene, JSON} ─▶ engine process      once per world
//!        ── TickInput, f64s ──────────▶ (mujoco, or yours)   every tick of 1 ms
//!        ◀───────────── PhysicsState ──
//! ```
//!
//! An engine computes only the motion of joints and objects and the forces on the skin. Sensors,
//! noise, errors, drives, faults and ground truth stay in [`World`](crate::World). They are
//! therefore the same for all engines. [`EngineProcess`] describes the messages.

mod description;
mod pipe;
mod pool;
mod process;
mod state;

pub use description::{
    EngineFingertip, EngineFrame, EngineHand, EngineJoint, EngineNeck, EngineObject, EnginePin,
    EnginePlate, EngineScene, EngineShape, EngineThread, PROTOCOL,
};
pub use pool::EnginePool;
pub use process::{EngineCommand, EngineProcess};
pub use state::{CapState, ObjectState, PhysicsState, TickInput};

/// Physics engine that simulates one scene at a time.
pub trait Engine: Send + Sync {
    /// Builds the scene; the engine forgets the previous one.
    ///
    /// # Errors
    /// The engine cannot build the scene, or has ended.
    fn begin(&mut self, scene: &EngineScene) -> Result<(), EngineError>;

    /// Simulates one tick and writes its end to `state`.
    ///
    /// # Errors
    /// The solver warned, a value is not finite, or the engine has ended.
    fn advance(&mut self, input: &TickInput, state: &mut PhysicsState) -> Result<(), EngineError>;
}

/// Failure of an engine.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum EngineError {
    /// The command is not usable.
    #[error("engine rejected: {0}")]
    Command(String),
    /// The process could not be started.
    #[error(
        "could not start the engine: {program}: {reason}; install it (`pip install \
         'atas[mujoco]'`) or correct --engine"
    )]
    Start {
        /// Program of the command.
        program: String,
        /// Error of the operating system.
        reason: String,
    },
    /// The engine cannot build the scene.
    #[error("could not build the scene: {0}")]
    Scene(String),
    /// The engine reports a failed tick.
    #[error("the engine failed: {0}")]
    Tick(String),
    /// The process did not answer in time.
    #[error(
        "the engine did not answer within {seconds} s and is ended; see its messages above, or \
         simulate with the built-in engine"
    )]
    Timeout {
        /// Time limit, s.
        seconds: f64,
    },
    /// The process ended or broke the protocol.
    #[error("could not exchange data with the engine: {0}; see its messages above")]
    Connection(String),
}
