//! Engines for several worlds at once: each world borrows one, and returns it when it is dropped.

use std::sync::{Arc, Mutex, PoisonError};

use super::{
    Engine, EngineCommand, EngineError, EngineProcess, EngineScene, PhysicsState, TickInput,
};

/// Idle engines of one command. Starts an engine if none is idle.
#[derive(Clone, Debug)]
pub struct EnginePool {
    command: EngineCommand,
    idle: Arc<Mutex<Vec<EngineProcess>>>,
}

/// Engine that returns to its pool.
#[derive(Debug)]
struct Borrowed {
    /// `None` after the drop has begun.
    engine: Option<EngineProcess>,
    pool: EnginePool,
}

impl EnginePool {
    /// Returns a pool without engines.
    #[must_use]
    pub fn new(command: EngineCommand) -> Self {
        Self {
            command,
            idle: Arc::default(),
        }
    }

    /// Borrows an idle engine, or starts one.
    ///
    /// # Errors
    /// [`EngineError::Start`] if the engine does not start.
    pub fn borrow(&self) -> Result<Box<dyn Engine>, EngineError> {
        let idle = self
            .idle
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
            .pop();
        let engine = match idle {
            Some(engine) => engine,
            None => EngineProcess::start(&self.command)?,
        };
        Ok(Box::new(Borrowed {
            engine: Some(engine),
            pool: self.clone(),
        }))
    }
}

impl Borrowed {
    fn engine(&mut self) -> Result<&mut EngineProcess, EngineError> {
        let ended = || EngineError::Connection("it was returned".to_owned());
        self.engine.as_mut().ok_or_else(ended)
    }
}

impl Engine for Borrowed {
    fn begin(&mut self, scene: &EngineScene) -> Result<(), EngineError> {
        self.engine()?.begin(scene)
    }

    fn advance(&mut self, input: &TickInput, state: &mut PhysicsState) -> Result<(), EngineError> {
        self.engine()?.advance(input, state)
    }
}

impl Drop for Borrowed {
    fn drop(&mut self) {
        if let Some(engine) = self.engine.take().filter(|engine| !engine.is_lost()) {
            let idle = self.pool.idle.lock();
            idle.unwrap_or_else(PoisonError::into_inner).push(engine);
        }
    }
}
