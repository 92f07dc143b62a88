//! EBTS: behaviour tables for teams of mobile robots, evolved by a genetic algorithm (paper section
//! III).
//!
//! Inputs: a [`condition::Condition`] (field preset, team size, [`scoring`]) and a seed. Outputs:
//! the best table found with its provenance ([`table_file`]); over many seeds, the findings of the
//! paper that hold ([`experiment`], [`analysis`], [`plot`]).
//!
//! Layers, innermost first:
//!
//! * [`genome`] and [`table`]: genotype and its meaning.
//! * [`ga`] and [`islands`]: proposal and selection. [`training`]: choice of trials.
//! * [`evaluate`]: fitness of genomes from the simulators of the `field` crate, on the threads of
//!   [`workers`].
//! * [`run`]: one seed. [`checkpoint`] and [`experiment`]: runs on disk.
//! * [`analysis`]: behaviour of evolved tables. [`results`] and [`plot`]: output files.
//! * [`search`]: search for fields ([`variation`]) on which chosen findings hold.
//! * [`agents`]: controllers of the robots of a field on the bus.
//! * [`grasp`] and [`course`]: the same algorithm for a hand and for the base of a robot with
//!   hands.
//!
//! Invariants:
//!
//! * The bits of a run depend only on condition, settings and seed, not on SIMD width, threads,
//!   parallel runs, interruption or sharding (tests `tests/same_bits.rs` and `tests/commands/`).
//! * A finished run is on disk before it is reported. Finished runs are never lost or overwritten.
//! * Input is verified: files carry hashes, numbers are range-checked, genomes are evaluated again.
//!   Errors name the fault.
//!
//! Not part of this crate: unseeded randomness, clocks (except for save intervals), the field
//! itself, and any state that agents share other than their table.
//!
//! ```
//! use ebts::built_in;
//!
//! let team = built_in::table("r3-two-agents")?;
//! assert!(team.individual.fitness() > 600.0, "of 800 points");
//! # Ok::<(), ebts::error::Error>(())
//! ```

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
