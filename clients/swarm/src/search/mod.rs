//! Search for a preset on which chosen findings of the paper hold.
//!
//! Inputs: a preset, keys with ranges, the wanted [`crate::analysis::Claim`]s. Outputs: candidates
//! ([`candidates`]), stages with fewer candidates on more seeds ([`Halving`]), and the probability
//! that a candidate shows all claims ([`Score`]).
//!
//! Choosing among many candidates with few seeds also selects luck. The verdict therefore uses
//! seeds that took no part in the choice; [`Halving::check`] rejects overlapping seeds. The caller
//! runs the experiments ([`crate::experiment`]); this module uses neither files nor threads.

mod co_occurrence;
mod halving;
mod score;
mod space;

pub use co_occurrence::{CoOccurrence, co_occurrences};
pub use halving::{Halving, Stage};
pub use score::{ClaimScore, Score};
pub use space::{Candidate, Range, candidates};
