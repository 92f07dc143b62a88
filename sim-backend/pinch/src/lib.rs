//! A reduced grasp for evolution: two fingers pinch an object that stands on a table, and lift it.
//!
//! **In**: an [`Interface`] (what the bits and levels of a behaviour table mean) and [`Trial`]s (object, table, seed). **Out**:
//! an [`Outcome`] each: how it ended, how high, how far it slid, with what force, which rows of the table were read.
//!
//! What the full simulation (`sim-backend`, `atas-core`) has in 3-D is reduced to what decides a symmetric grasp: one finger
//! stands for two, an object moves up and down only, `skin` has ten bristles, `body` is stepped by 500 µs, `percept` feels
//! what the controller's perception would, and a table is read every millisecond. Evolution takes 160,000 such grasps per run.
//!
//! Invariants:
//!
//! * The bits of an outcome do not depend on the engine, on the number of trials in a call or on their order
//!   (test `tests/identical_bits.rs`): only IEEE `+ − × ÷`, comparison and selection; no fused multiply-add.
//! * Its verdicts agree with those of the full simulation: measured by `ebts agreement`, not assumed.
//!
//! Deliberately absent: turning in the hand, off-centre grips, arms, fitness, files, threads and learning.

mod body;
mod engine;
mod kernel;
mod lanes;
mod percept;
mod skin;
mod trial;

pub use engine::Engine;
pub use trial::{Bit, End, HOLD_S, Interface, LIFT_M, Object, Outcome, Patience, Rows, Trial};
