//! The whole system: real processes, real shared memory, each test on a bus of its own.

mod architecture;
mod arena;
mod contributing;
mod dashboard;
mod determinism;
mod explain;
mod faults;
mod features;
mod fingers;
mod follow;
mod foxglove;
mod gate;
mod guide;
mod imports;
mod optoforce;
mod readme;
mod recorded;
mod recordings;
mod replay;
mod restarts;
mod robots;
mod servos;
mod stopped;
mod swarm;
mod tasks;
mod top;
