//! Rust's errors as Python's.

use pyo3::exceptions::PyException;
use pyo3::prelude::*;

pyo3::create_exception!(
    atas,
    AtasError,
    PyException,
    "What went wrong in atas; the message says what to do."
);
pyo3::create_exception!(
    atas,
    BusError,
    AtasError,
    "The bus, or a process on it, is not as it was needed."
);

/// As [`AtasError`], with all its causes.
pub(crate) fn failed(error: anyhow::Error) -> PyErr {
    AtasError::new_err(format!("{error:#}"))
}

/// As [`BusError`].
pub(crate) fn of_bus(error: impl std::fmt::Display) -> PyErr {
    BusError::new_err(error.to_string())
}
