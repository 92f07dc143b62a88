//! Buses and hands by the names that users give them.

use std::str::FromStr;

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use shm_bus::BusName;
use shm_schemas::Hand;

/// A bus by its name, or the one that the environment names.
pub(crate) fn bus_name(name: Option<&str>) -> PyResult<BusName> {
    name.map_or_else(BusName::from_env, BusName::from_str)
        .map_err(|why| PyValueError::new_err(why.to_string()))
}

/// A hand by its name.
pub(crate) fn hand_of(name: &str) -> PyResult<Hand> {
    Hand::from_name(name).ok_or_else(|| {
        PyValueError::new_err(format!("a hand was {name:?}, needs \"left\" or \"right\""))
    })
}
