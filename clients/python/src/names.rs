//! Parses the names of buses and hands.

use std::str::FromStr;

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use robot_model::{HandSide, RobotModel};
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

/// Returns a hand that the robot has; without a name, the acting hand.
pub(crate) fn side_of(
    robot: &RobotModel,
    robot_name: &str,
    hand: Option<&str>,
) -> PyResult<HandSide> {
    let Some(name) = hand else {
        return Ok(robot.acting_side());
    };
    let side = HandSide::BOTH[usize::from(parse_hand(name)? != Hand::LEFT)];
    if robot.hand(side).is_present() {
        return Ok(side);
    }
    let other = match robot.acting_side() {
        HandSide::Left => "left",
        HandSide::Right => "right",
    };
    Err(PyValueError::new_err(format!(
        "unknown hand {name:?}: the robot {robot_name} has no such hand; use {other:?}"
    )))
}
