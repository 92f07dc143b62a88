//! Child processes of a demo, a measurement or a fault run, and the folder of their logs.
//!
//! * **In:** the name of a program beside this one, its arguments, a bus. **Out:** a [`Child`] that
//!   ends with its owner, and its log.
//! * **Invariants:** a child ends with this process, however that ends. The remains of a killed
//!   owner are removed by the next one ([`logs::remove_stale`]).
//! * **Not included:** the meaning of the programs; a caller chooses bus and arguments.

pub mod child;
pub mod logs;

pub use child::{Child, sibling_program};
pub use logs::Logs;
