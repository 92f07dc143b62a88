//! Reduced grasp model for evolution: two fingers pinch an object on a table and lift it.
//!
//! * **Inputs**: an [`Interface`] (meaning of a table's bits and levels) and [`Trial`]s (object,
//!   table, seed).
//! * **Outputs**: one [`Outcome`] per trial: end, height, slip, force, rows read.
//!
//! Compared with the full 3-D simulation (`sim-backend`, `atas-core`), one finger represents both
//! and the object only moves vertically. `skin` has ten bristles, `body` steps of 500 µs, `percept`
//! a reduced perception; the table is read every millisecond. An evolution run simulates 160,000
//! grasps.
//!
//! Invariants:
//!
//! * The bits of an outcome depend neither on the engine nor on the number or order of trials (test
//!   `tests/identical_bits.rs`): only IEEE `+ − × ÷`, comparison and selection; no fused
//!   multiply-add.
//! * Results agree with the full simulation, as measured by `ebts agreement`.
//!
//! Excluded: rotation in the hand, off-centre grasps, arms, fitness, files, threads, learning.

mod body;
mod engine;
mod kernel;
mod lanes;
mod percept;
mod skin;
mod trial;

pub use engine::Engine;
pub use trial::{Bit, End, HOLD_S, Interface, LIFT_M, Object, Outcome, Rows, TimeLimit, Trial};
