//! Stop and recovery, as by `atas estop` and `atas recover`.

use std::time::Duration;

use atas_client::{Session, request_stop};
use shm_bus::BusName;
use shm_schemas::ControlOp;

/// Longest time until the daemon acknowledges a stop (design choice: normally one tick).
const REPLY_TIMEOUT: Duration = Duration::from_millis(800);

/// Stops the robot over every channel of the daemon.
pub(crate) fn stop(bus: &BusName) -> anyhow::Result<()> {
    request_stop(bus, "the dashboard", REPLY_TIMEOUT)?;
    Ok(())
}

pub(crate) fn recover(bus: &BusName) -> anyhow::Result<()> {
    Session::existing(bus)?.request_success(ControlOp::RECOVER, 0.0, "")?;
    Ok(())
}
