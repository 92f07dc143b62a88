//! The whole system: real processes, real shared memory, each test on a bus of its own.

mod architecture;
mod determinism;
mod faults;
mod imports;
mod optoforce;
mod readme;
mod recordings;
mod swarm;
mod tasks;
