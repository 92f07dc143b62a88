//! Production perception on recordings of real fingertips, judged by labels.
//!
//! ```text
//!  run.mcap ─▶ run ┐ (spans of a table of labels)
//!  FILE.csv ───────┴▶ Sheet (rows) ─▶ Kind (which columns) ─▶ cases (one sequence, squeeze or press each)
//!                                                       │ frames through intake and perception of atas-core
//!                                                       ▼
//!        Model (constants in force) ───────────▶ score of every case ─▶ Verdict: rates, AUC, errors
//! ```
//!
//! What a recording can be judged for follows from its columns ([`Kind`]): slip against stable touch, hard against soft, the
//! force at which flesh ruptures, touches.
//!
//! * **In:** a table with one row per frame, or a run that `atas record` wrote, the name of the column that holds the truth, a [`Model`]. **Out:** a [`Verdict`].
//! * **Invariants:** the frames pass the production intake and perception, whose filters and windows are in seconds of the
//!   sensor's time. The score of a case never sees its label. Whatever is fitted is fitted on other cases than are judged:
//!   those of another file, or those of other objects ([`Fit::Across`]). The same file gives the same numbers.
//! * **Absent on purpose:** learning beyond a threshold or a line: each constant has a name and a place in a file.

mod cases;
mod decision;
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
mod soundness;
mod steps;
mod touches;
mod verdict;

pub use cases::Labels;
pub use decision::Fit;
pub use judge::{judge, train};
pub use kind::{Judged, Kind};
pub use model::{Hardness, Line, Model, Rupture, Slip, Touch};
pub use rates::{Rates, auc};
pub use run::open;
pub use sheet::Sheet;
pub use slip::greatest_motion;
pub use verdict::{After, Errors, Verdict};
