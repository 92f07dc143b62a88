//! Files with own atomics, compiled with those of loom.
//!
//! * [`signal`]: a stop on its way from the stop socket to the tick, and back to its sender.
//! * [`exchange`]: tables that the operator replaces while the loop of a robot runs.
//!
//! All other atomics of the workspace are counters and flags that publish no other data, so relaxed
//! ordering suffices: log lines lost, entries dropped, end of a loop, time of the last round. The
//! rings come from `rtrb`, `triple_buffer` and `crossbeam`, and a buffer in a ring has one owner.
#![cfg(loom)]

#[path = "../../../clients/swarm/src/agents/exchange.rs"]
pub mod exchange;
#[path = "../../../shm-schemas/bus/src/stop/signal.rs"]
pub mod signal;

/// Stands for the tables that an [`exchange::Exchange`] carries.
#[derive(Debug, Default, PartialEq, Eq)]
pub struct Lookup(pub u32);
