//! Search for a preset on which chosen findings of the paper hold.
//!
//! **In**: a preset, keys with ranges, the wanted [`crate::analysis::Claim`]s. **Out**: candidates ([`candidates`]), stages of
//! fewer candidates on more seeds ([`Halving`]), and how likely each candidate is to show them all ([`Score`]).
//!
//! Whoever chooses among many by few seeds chooses luck as well: what is chosen is judged on seeds that nothing was chosen
//! with, and [`Halving::check`] refuses a verdict on seeds of the tuning. Running the experiments is the caller's
//! ([`crate::experiment`]); nothing here has files or threads.

mod halving;
mod score;
mod space;
mod together;

pub use halving::{Halving, Stage};
pub use score::{Judged, Score};
pub use space::{Candidate, Range, candidates};
pub use together::{Together, together};
