//! Values that belong to one thread of one process.

use std::mem;
use std::process;
use std::thread::{self, ThreadId};

use pyo3::prelude::*;

use crate::errors::BusError;

/// A value that only the thread that made it may use and drop, in the process that made it.
///
/// After `fork`, parent and child have the same shared memory. The child's copy is inert, and so is
/// a value in another thread: using it is an error. Dropping it there leaves it open until the
/// process ends.
pub(crate) struct OwnThread<T> {
    /// `None` only while it is dropped.
    value: Option<T>,
    pid: u32,
    thread: ThreadId,
}

// SAFETY: only the thread that made the value reaches it: `get`, `get_mut` and `drop` compare the
// thread, and identities of threads are never used again.
unsafe impl<T> Send for OwnThread<T> {}
// SAFETY: as above.
unsafe impl<T> Sync for OwnThread<T> {}

impl<T> OwnThread<T> {
    pub(crate) fn new(value: T) -> Self {
        Self {
            value: Some(value),
            pid: process::id(),
            thread: thread::current().id(),
        }
    }

    /// Returns the value; an error in another process or thread.
    pub(crate) fn get(&self) -> PyResult<&T> {
        self.check()?;
        self.value.as_ref().ok_or_else(closed)
    }

    /// As [`OwnThread::get`].
    pub(crate) fn get_mut(&mut self) -> PyResult<&mut T> {
        self.check()?;
        self.value.as_mut().ok_or_else(closed)
    }

    fn is_own(&self) -> bool {
        self.pid == process::id() && self.thread == thread::current().id()
    }

    fn check(&self) -> PyResult<()> {
        if self.is_own() {
            return Ok(());
        }
        let why = if self.pid == process::id() {
            "in another thread than the one that opened it; open `atas.Bus` in each thread"
                .to_owned()
        } else {
            let pid = process::id();
            format!(
                "after a fork: process {} opened it, this is process {pid}; open `atas.Bus` here",
                self.pid
            )
        };
        Err(BusError::new_err(format!("could not use the bus {why}")))
    }
}

fn closed() -> PyErr {
    BusError::new_err("the bus is closed")
}

impl<T> Drop for OwnThread<T> {
    fn drop(&mut self) {
        if self.is_own() {
            return;
        }
        mem::forget(self.value.take());
        if self.pid == process::id() {
            let why = "a handle of the bus was dropped in another thread than the one that opened it; \
                       it stays open, and an attached goal goes on, until the process ends";
            Python::attach(|py| BusError::new_err(why).write_unraisable(py, None));
        }
    }
}
