//! Production perception on recordings of real fingertips, evaluated against labels.
//!
//! ```text
//!  run.mcap ─▶ run ┐ (labelled time spans)
//!  FILE.csv ───────┴▶ Sheet (rows) ─▶ Kind (columns) ─▶ cases (sequence, squeeze or press)
//!                                         │ frames through intake and perception of atas-core
//!                                         ▼
//!        Model (constants) ───────────▶ score of every case ─▶ Verdict: rates, AUC, errors
//! ```
//!
//! The columns determine the evaluation ([`Kind`]): slip, hardness, rupture force, or contact.
//!
//! * **In:** a table with one row per frame, or a run of `atas record`; the name of the label
//!   column; a [`Model`]. **Out:** a [`Verdict`].
//! * **Invariants:** frames pass the production intake and perception in sensor time. Scores do not
//!   depend on labels. Constants are fitted on another file, or on other objects ([`Fit::Across`]).
//!   The same file gives the same numbers.
//! * **Not included:** learning beyond a threshold or a line. Each constant has a name in the model
//!   file.

mod cases;
mod decision;
mod defects;
mod hardness;
mod judge;
mod kind;
mod model;
mod rates;
mod run;
mod rupture;
mod sheet;
mod skin;
mod slip;
mod steps;
mod touches;
mod verdict;

pub use cases::Labels;
pub use decision::Fit;
pub use judge::{evaluate, train};
pub use kind::{Kind, Property};
pub use model::{Hardness, Line, Model, Rupture, Slip, Touch};
pub use rates::{Rates, auc};
pub use run::open;
pub use sheet::Sheet;
pub use slip::greatest_motion;
pub use verdict::{After, Errors, Verdict};
