//! Stop and recover, as `atas estop` and `atas recover` do them.

use std::time::Duration;

use atas_client::Session;
use shm_bus::{BusError, BusName, stop};
use shm_schemas::ControlOp;

/// How long the daemon may take to take a stop (ours: an answer takes one tick).
const ANSWER: Duration = Duration::from_millis(800);

/// Stops the robot on the way that nothing else can occupy; by a control request only where no daemon listens there.
pub(crate) fn stop(bus: &BusName) -> anyhow::Result<()> {
    match stop::request(bus, "the dashboard", ANSWER) {
        Ok(_) => Ok(()),
        Err(nobody @ BusError::NoServer { .. }) => {
            let asked = Session::existing(bus).and_then(|s| s.demand(ControlOp::ESTOP, 0.0, ""));
            asked.map(|_| ()).map_err(|_| nobody.into())
        }
        Err(error) => Err(error.into()),
    }
}

/// Leaves a stop or a hold.
pub(crate) fn recover(bus: &BusName) -> anyhow::Result<()> {
    Session::existing(bus)?.demand(ControlOp::RECOVER, 0.0, "")?;
    Ok(())
}
