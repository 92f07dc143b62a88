//! Parses the names of buses and hands.

use std::str::FromStr;

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use shm_bus::BusName;
use shm_schemas::Hand;

/// Parses a bus name; default from the environment.
pub(crate) fn bus_name(name: Option<&str>) -> PyResult<BusName> {
    name.map_or_else(BusName::from_env, BusName::from_str)
        .map_err(|why| PyValueError::new_err(why.to_string()))
}

/// Parses the name of a hand.
pub(crate) fn parse_hand(name: &str) -> PyResult<Hand> {
    Hand::from_name(name).ok_or_else(|| {
        PyValueError::new_err(format!(
            "unknown hand {name:?}; needs \"left\" or \"right\""
        ))
    })
}
