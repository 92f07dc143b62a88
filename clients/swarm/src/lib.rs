//! EBTS: behaviour tables for teams of mobile robots, evolved by a genetic algorithm (paper section III).
//!
//! **In**: a [`condition::Condition`] (field preset, team size, [`scoring`]), a seed. **Out**: the best table found, with its
//! provenance ([`table_file`]), and, over many seeds, what of the paper holds ([`experiment`], [`analysis`], [`plot`]).
//!
//! From the inside out: [`genome`] and [`table`] are the genotype and what it means; [`ga`] and [`islands`] propose and
//! select; [`training`] says on which trials, [`evaluate`] turns genomes into fitness with the `field` crate's simulators, on as many threads as [`workers`]
//! has; [`run`] puts these together for one seed; [`checkpoint`] and [`experiment`] keep runs on disk; [`analysis`] looks at
//! what evolved, [`results`] and [`plot`] write it down; [`search`] looks for fields ([`variation`]) on which all of it holds; [`agents`] drives the robots of a field on the bus. The same algorithm
//! evolves tables for other agents: a hand ([`grasp`]), and the base of a robot with hands ([`course`]).
//!
//! Invariants:
//!
//! * A run's bits depend on its condition, settings and seed alone: not on SIMD width, threads, the runs beside it,
//!   interruption or sharding (tests `tests/same_bits.rs` and `tests/commands/`).
//! * A run that finished is on the disk before anybody is told so, and nothing finished is ever lost or overwritten.
//! * Nothing from outside is believed: files carry hashes, numbers are checked, genomes are evaluated again, and what is
//!   wrong is said.
//!
//! Deliberately absent: unseeded randomness, and clocks but for when to save; the field itself; anything the agents would
//! have to share besides their table.

pub mod agents;
pub mod analysis;
pub mod built_in;
pub mod checkpoint;
pub mod condition;
pub mod course;
pub mod error;
pub mod evaluate;
pub mod experiment;
pub mod files;
pub mod ga;
mod generations;
pub mod genome;
pub mod grasp;
pub mod islands;
mod memo;
pub mod plot;
pub mod replay;
pub mod results;
pub mod rng;
pub mod run;
pub mod scoring;
pub mod search;
pub mod sensors;
mod setup;
pub mod stats;
pub mod table;
pub mod table_file;
pub mod training;
pub mod variation;
pub mod workers;
