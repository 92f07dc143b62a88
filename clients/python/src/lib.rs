//! The Python package `atas`, its part in Rust (`atas._native`).
//!
//! ```text
//!  rows       payloads as NumPy arrays: the array's type is made from the schema
//!  bus        Bus ─▶ Reader (arrays), Sensor (frames), Robot (joints, commands), Goal, Leader (targets); requests
//!  simulation the simulator with the production controller, tick by tick
//!  recording  recordings as arrays, replayed by the production controller
//!  learning   environments, one or many
//! ```
//!
//! * **In, out:** what the docstrings say. **Invariants:** the bus's rules (seals, sequences, epochs, lock-step, which commands are
//!   obeyed) are kept here and cannot be broken from Python; what is received is copied once, from shared memory into the
//!   array; whatever waits or computes lets other Python threads run.
//! * **Absent on purpose:** what is not Rust: enumerations, environments'
//!   spaces and wrappers are Python (`python/atas`).

mod bus;
mod errors;
mod goal;
mod leader;
mod learning;
mod names;
mod reader;
mod recording;
mod robot;
mod rows;
mod sensor;
mod simulation;

use pyo3::prelude::*;

/// What the package `atas` is made of; use it through `import atas`.
#[pymodule]
mod _native {
    #[pymodule_export]
    use super::bus::{Bus, wipe};
    #[pymodule_export]
    use super::errors::{AtasError, BusError};
    #[pymodule_export]
    use super::goal::Goal;
    #[pymodule_export]
    use super::leader::Leader;
    #[pymodule_export]
    use super::learning::{Batch, Environment, parts};
    #[pymodule_export]
    use super::reader::Reader;
    #[pymodule_export]
    use super::recording::Recording;
    #[pymodule_export]
    use super::robot::Robot;
    #[pymodule_export]
    use super::rows::{codes, dtype, reason};
    #[pymodule_export]
    use super::sensor::{Sensor, layout};
    #[pymodule_export]
    use super::simulation::{Simulation, objects};

    use pyo3::prelude::*;

    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        module.add("__version__", env!("CARGO_PKG_VERSION"))?;
        module.add("FINGERS", shm_schemas::capacity::FINGERS)?;
        module.add("ELEMENTS", shm_schemas::capacity::ELEMENTS)?;
        let joint_names = super::robot::joint_names()?;
        module.add("JOINTS", joint_names.len())?;
        module.add("JOINT_NAMES", joint_names)
    }

    /// Nanoseconds of CLOCK_MONOTONIC: the time of every stamp on the bus.
    #[pyfunction]
    fn now_ns() -> u64 {
        shm_bus::now_ns()
    }
}

/// Sleeps without holding up other Python threads, and lets Ctrl-C through.
fn pause(py: Python<'_>, time: std::time::Duration) -> PyResult<()> {
    py.detach(|| std::thread::sleep(time));
    py.check_signals()
}
