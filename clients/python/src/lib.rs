//! Rust part (`atas._native`) of the Python package `atas`.
//!
//! ```text
//!  rows       payloads as NumPy arrays; the array types are derived from the schema
//!  bus        Bus ─▶ Reader (arrays), Sensor (frames), Robot (joints), Goal, Teleop (targets)
//!  kinematics pinch poses of joint positions, for leader arms
//!  simulation the simulator with the production controller, tick by tick
//!  scene      scenes and goals by name; picture: views of a scene as arrays
//!  recording  recordings as arrays, replay with the production controller
//!  learning   environments, one or many
//!  swarm      fitness of behaviour tables and the genetic algorithm, as ask and tell
//!  contacts   contacts of the MuJoCo engine, read once per tick
//! ```
//!
//! * **Invariants:** this crate enforces the rules of the bus (seals, sequences, epochs, lock-step,
//!   command validation); Python code cannot break them. Received data are copied once, from shared
//!   memory into the array. Waiting and computing release the Python lock.
//! * **Not included:** enumerations, spaces and wrappers of environments are Python
//!   (`python/atas`).

mod bus;
mod contacts;
mod errors;
mod goal;
mod kinematics;
mod learning;
mod names;
mod own_thread;
mod picture;
mod reader;
mod recording;
mod robot;
mod rows;
mod scene;
mod sensor;
mod simulation;
mod swarm;
mod teleop;

use std::panic::AssertUnwindSafe;

use pyo3::prelude::*;

use crate::errors::AtasError;

/// Rust part of the package `atas`; use it through `import atas`.
#[pymodule]
mod _native {
    #[pymodule_export]
    use super::bus::{Bus, wipe};
    #[pymodule_export]
    use super::contacts::Contacts;
    #[pymodule_export]
    use super::errors::{AtasError, BusError};
    #[pymodule_export]
    use super::goal::Goal;
    #[pymodule_export]
    use super::kinematics::Kinematics;
    #[pymodule_export]
    use super::learning::{Batch, Environment};
    #[pymodule_export]
    use super::reader::Reader;
    #[pymodule_export]
    use super::recording::Recording;
    #[pymodule_export]
    use super::robot::Robot;
    #[pymodule_export]
    use super::rows::{codes, dtype, reason};
    #[pymodule_export]
    use super::scene::objects;
    #[pymodule_export]
    use super::sensor::{Sensor, layout};
    #[pymodule_export]
    use super::simulation::Simulation;
    #[pymodule_export]
    use super::swarm::{SwarmField, SwarmSearch};
    #[pymodule_export]
    use super::teleop::Teleop;

    use pyo3::prelude::*;

    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        module.add("__version__", env!("CARGO_PKG_VERSION"))?;
        module.add("abi", shm_bus::Abi::current().to_string())?;
        module.add("FINGERS", shm_schemas::capacity::FINGERS)?;
        module.add("ELEMENTS", shm_schemas::capacity::ELEMENTS)?;
        let joint_names = super::robot::joint_names()?;
        module.add("JOINTS", joint_names.len())?;
        module.add("JOINT_NAMES", joint_names)
    }

    /// Current time of CLOCK_MONOTONIC, ns: the time of all stamps on the bus.
    #[pyfunction]
    fn now_ns() -> u64 {
        shm_bus::now_ns()
    }
}

/// Computes with the Python lock released. A panic becomes an `AtasError`: pyo3's own exception
/// would escape `except Exception`.
fn compute<T: Send>(py: Python<'_>, work: impl FnOnce() -> T + Send) -> PyResult<T> {
    let done = py.detach(|| std::panic::catch_unwind(AssertUnwindSafe(work)));
    done.map_err(|panic| {
        let text = panic.downcast_ref::<&str>().copied();
        let text = text.or_else(|| panic.downcast_ref::<String>().map(String::as_str));
        AtasError::new_err(format!(
            "internal error: {}; please report it with the call that raised it",
            text.unwrap_or("no message")
        ))
    })
}

/// Sleeps with the Python lock released, then handles Ctrl-C.
fn pause(py: Python<'_>, time: std::time::Duration) -> PyResult<()> {
    py.detach(|| std::thread::sleep(time));
    py.check_signals()
}
