//! Stop and recovery, as by `atas estop` and `atas recover`.

use std::time::Duration;

use atas_client::Session;
use shm_bus::{BusError, BusName, stop};
use shm_schemas::ControlOp;

/// Longest time until the daemon acknowledges a stop (design choice: normally one tick).
const REPLY_TIMEOUT: Duration = Duration::from_millis(800);

/// Stops the robot over the reserved stop channel; uses a control request only if no daemon serves
/// that channel.
pub(crate) fn stop(bus: &BusName) -> anyhow::Result<()> {
    match stop::request(bus, "the dashboard", REPLY_TIMEOUT) {
        Ok(_) => Ok(()),
        Err(nobody @ BusError::NoServer { .. }) => {
            let asked =
                Session::existing(bus).and_then(|s| s.request_success(ControlOp::ESTOP, 0.0, ""));
            asked.map(|_| ()).map_err(|_| nobody.into())
        }
        Err(error) => Err(error.into()),
    }
}

pub(crate) fn recover(bus: &BusName) -> anyhow::Result<()> {
    Session::existing(bus)?.request_success(ControlOp::RECOVER, 0.0, "")?;
    Ok(())
}
