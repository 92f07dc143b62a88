//! Grasping with a behaviour table (methodology 2 of the paper; its obstacle: "a tremendous number
//! of iterations").
//!
//! A hand uses the paper's table format: five sensor bits (from touch) and two actuators of two
//! bits (fingers and lift of the hand), 128 bits (Eq. 1, [`course`]). The unchanged genetic
//! algorithm runs in a reduced simulation ([`evolve`], crate `pinch`) with eight object families
//! for the eight goals ([`fitness`]).
//!
//! [`verdict`] evaluates tables with the production controller in the full simulation.
//! [`description`] compares a table with the paper's modules, [`rules`] writes them by hand, and
//! [`agreement`] measures the quality of the reduced simulation.
//!
//! Invariants: the bits of a run depend only on seed, generations and settings. Reading a table
//! file evaluates its table again.
//!
//! Not part of this module: islands and checkpoints within a run. A run takes seconds, and an
//! experiment saves each.

pub mod agreement;
pub mod course;
pub mod description;
pub mod evolve;
pub mod figure;
pub mod fitness;
pub mod rules;
pub mod table_file;
pub mod verdict;
