//! A behaviour table that feels: methodology 2 grasps (the paper's obstacle: "a tremendous number of iterations").
//!
//! The paper's table has five sensor bits and two actuators of two bits, 128 bits in all (Eq. 1). A hand fits the same table:
//! the bits are told from touch, the actuators are the fingers and the hand on its way up ([`course`]). The same genetic
//! algorithm evolves it in a reduced simulation ([`evolve`], the crate `pinch`), with eight objects for the eight goals
//! ([`fitness`]). Then the production controller reads it in the full simulation ([`verdict`]), and [`words`] says which of the
//! paper's modules it has found again. [`rules`] has them written by hand; [`agreement`] measures what the reduced simulation
//! is worth.
//!
//! * **Invariants:** a run's bits depend on its seed, generations and settings alone; a table file is believed only after its
//!   table was evaluated again.
//! * **Absent on purpose:** islands and checkpoints within a run: a run takes seconds, and an experiment saves each.

pub mod agreement;
pub mod course;
pub mod evolve;
pub mod figure;
pub mod fitness;
pub mod rules;
pub mod table_file;
pub mod verdict;
pub mod words;
