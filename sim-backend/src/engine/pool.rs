//! Engines for several worlds at once: each world borrows one, and returns it when it is dropped.
//!
//! An engine and the thread that borrows it wait for each other in turn. They share a core: waking
//! a process on an idle core takes longer than its message (measured: 0.24 ms of system time per
//! tick on two cores, 0.03 ms on one).

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use rustix::thread::{CpuSet, sched_getaffinity, sched_setaffinity};

use super::{
    Engine, EngineCommand, EngineError, EngineProcess, EngineScene, PhysicsState, TickInput,
};

/// Idle engines of one command. Starts an engine if none is idle.
#[derive(Clone, Debug)]
pub struct EnginePool {
    command: EngineCommand,
    /// Cores of this process.
    cores: Arc<[usize]>,
    seats: Arc<Mutex<Seats>>,
}

#[derive(Debug, Default)]
struct Seats {
    idle: Vec<Seat>,
    count: usize,
}

/// Core of an engine, and the engine if it has been started and is not lost.
#[derive(Debug)]
struct Seat {
    core: Option<usize>,
    engine: Option<EngineProcess>,
}

/// Engine that returns to its pool.
#[derive(Debug)]
struct Borrowed {
    seat: Seat,
    pool: EnginePool,
    /// Cores of the borrowing thread before; `None` if they did not change.
    cores_before: Option<CpuSet>,
}

impl EnginePool {
    /// Returns a pool without engines.
    #[must_use]
    pub fn new(command: EngineCommand) -> Self {
        let allowed = sched_getaffinity(None);
        let is_allowed = |core: &usize| allowed.is_ok_and(|cores| cores.is_set(*core));
        Self {
            command,
            cores: (0..CpuSet::MAX_CPU).filter(is_allowed).collect(),
            seats: Arc::default(),
        }
    }

    /// Borrows an idle engine, or starts one. Until it is returned, this thread runs on the
    /// engine's core.
    ///
    /// # Errors
    /// [`EngineError::Start`] if the engine does not start.
    pub fn borrow(&self) -> Result<Box<dyn Engine>, EngineError> {
        let seat = self.take_seat();
        let mut borrowed = Borrowed {
            cores_before: seat.core.and_then(move_to),
            seat,
            pool: self.clone(),
        };
        if borrowed.seat.engine.is_none() {
            // The process inherits the core of this thread.
            borrowed.seat.engine = Some(EngineProcess::start(&self.command)?);
        }
        Ok(Box::new(borrowed))
    }

    /// Returns an idle seat, or a new one on the next core.
    fn take_seat(&self) -> Seat {
        let mut seats = self.seats();
        if let Some(seat) = seats.idle.pop() {
            return seat;
        }
        let number = seats.count;
        seats.count += 1;
        Seat {
            core: self.cores.get(number % self.cores.len().max(1)).copied(),
            engine: None,
        }
    }

    fn seats(&self) -> MutexGuard<'_, Seats> {
        self.seats.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Moves this thread to a core; returns its cores before, or `None` if it cannot be moved. The
/// simulation is then only slower.
fn move_to(core: usize) -> Option<CpuSet> {
    let before = sched_getaffinity(None).ok()?;
    let mut cores = CpuSet::new();
    cores.set(core);
    sched_setaffinity(None, &cores).ok()?;
    Some(before)
}

impl Borrowed {
    fn engine(&mut self) -> Result<&mut EngineProcess, EngineError> {
        let ended = || EngineError::Connection("it was returned".to_owned());
        self.seat.engine.as_mut().ok_or_else(ended)
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
        let engine = self.seat.engine.take();
        let seat = Seat {
            core: self.seat.core,
            engine: engine.filter(|engine| !engine.is_lost()),
        };
        self.pool.seats().idle.push(seat);
        if let Some(cores) = self.cores_before {
            // Fails only if these cores were taken from the process meanwhile.
            let _ = sched_setaffinity(None, &cores);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn engines_have_different_cores_and_threads_get_theirs_back() {
        let pool = EnginePool::new("cat".parse().expect("a command"));
        let before = sched_getaffinity(None).expect("known");
        let cores: Vec<usize> = {
            let seats = [pool.take_seat(), pool.take_seat()];
            let cores = seats.iter().map(|seat| seat.core.expect("a core"));
            cores.collect()
        };
        assert!(pool.cores.len() == 1 || cores[0] != cores[1], "{cores:?}");
        for _ in 0..3 {
            let engine = pool.borrow().expect("cat starts");
            assert_eq!(sched_getaffinity(None).expect("known").count(), 1);
            drop(engine);
            assert_eq!(sched_getaffinity(None).expect("known"), before);
            assert_eq!(pool.seats().idle.len(), 1);
        }
        assert_eq!(pool.seats().count, 3);
    }
}
