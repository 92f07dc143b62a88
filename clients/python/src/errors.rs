//! Conversion of Rust errors to Python exceptions.

use pyo3::exceptions::PyException;
use pyo3::prelude::*;

pyo3::create_exception!(
    atas,
    AtasError,
    PyException,
    "Failure in atas; the message contains cause and advice."
);
pyo3::create_exception!(
    atas,
    BusError,
    AtasError,
    "Failure of the bus or of a process on it."
);

/// Converts an error with all its causes to [`AtasError`].
pub(crate) fn atas_error(error: anyhow::Error) -> PyErr {
    AtasError::new_err(format!("{error:#}"))
}

/// Converts an error to [`BusError`].
pub(crate) fn bus_error(error: impl std::fmt::Display) -> PyErr {
    BusError::new_err(error.to_string())
}
