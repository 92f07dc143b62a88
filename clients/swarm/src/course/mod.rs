//! A behaviour table that drives a robot with hands: search an object of light, come within its reach, carry it to a goal of
//! light (the paper's plan: macro motion from tables, fine motion from modules).
//!
//! The table is the paper's: five sensor bits, two wheels of two bits, 128 bits. One table serves the whole course: which light
//! its photo sensors look for is the coordinator's to say. The genetic algorithm is the paper's, unchanged ([`evolve`]); what a
//! table is worth is told by driving it over courses drawn at random, with the very base, guard, sensors and coordinator of `atas eval
//! hybrid`, and with hands that only take their time ([`offline`]).
//!
//! * **Invariants:** a run's bits depend on its seed, generations and settings alone; a table file is believed only after its
//!   table was evaluated again.
//! * **Absent on purpose:** hands that fail, bumps, islands and checkpoints: a run takes minutes.

pub mod evolve;
pub mod fitness;
pub mod offline;
pub mod table_file;
