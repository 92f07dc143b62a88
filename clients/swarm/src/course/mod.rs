//! Behaviour table of a mobile robot with hands: search a luminous object, approach it, carry it to
//! a luminous goal (the paper's concept: macro motion by tables, fine motion by modules).
//!
//! The table is that of the paper: five sensor bits, two wheels of two bits, 128 bits. One table
//! serves the whole course; the coordinator selects the light that the photo sensors detect. The
//! genetic algorithm is unchanged ([`evolve`]). The fitness comes from random courses with the
//! base, collision guard, sensors and coordinator of `atas eval hybrid`; hands are reduced to time
//! delays ([`offline`]).
//!
//! Invariants: the bits of a run depend only on seed, generations and settings. Reading a table
//! file evaluates its table again.
//!
//! Not part of this module: failing hands, bumps, islands and checkpoints (a run takes minutes).

pub mod evolve;
pub mod fitness;
pub mod offline;
pub mod table_file;
