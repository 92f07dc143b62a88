//! Values that belong to one process.

use std::mem;
use std::process;

use pyo3::prelude::*;

use crate::errors::BusError;

/// A value that only the process that made it may use and drop.
///
/// After `fork`, parent and child have the same shared memory. The child's copy is inert: using it
/// is an error, and dropping it leaves the memory to the parent.
pub(crate) struct OwnProcess<T> {
    /// `None` only while it is dropped.
    value: Option<T>,
    pid: u32,
}

impl<T> OwnProcess<T> {
    pub(crate) fn new(value: T) -> Self {
        Self {
            value: Some(value),
            pid: process::id(),
        }
    }

    /// Returns the value; an error in another process.
    pub(crate) fn get(&self) -> PyResult<&T> {
        let value = self.value.as_ref().filter(|_| self.pid == process::id());
        value.ok_or_else(|| self.error())
    }

    /// As [`OwnProcess::get`].
    pub(crate) fn get_mut(&mut self) -> PyResult<&mut T> {
        if self.pid != process::id() {
            return Err(self.error());
        }
        self.value
            .as_mut()
            .ok_or_else(|| BusError::new_err("the bus is closed"))
    }

    fn error(&self) -> PyErr {
        BusError::new_err(format!(
            "could not use the bus after a fork: process {} opened it, this is process {}; open \
             `atas.Bus` here",
            self.pid,
            process::id()
        ))
    }
}

impl<T> Drop for OwnProcess<T> {
    fn drop(&mut self) {
        if self.pid != process::id() {
            mem::forget(self.value.take());
        }
    }
}
