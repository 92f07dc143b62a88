//! Assurance case: claims about safety, the evidence of each, and its last results.
//!
//! ```text
//!  case.toml ─▶ Case ─▶ evidence ─▶ commands (`atas fault run`, `atas soak`, tests) ─▶ Outcome
//!                │                                                                        │
//!                └──────────────▶ Assessment: claims, results, problems ◀── Results ◀─────┘
//!                                  └─▶ page of the guide, JSON
//! ```
//!
//! * **In:** the case, the fault catalogue, stored results, a source tree. **Out:** an
//!   [`Assessment`], its page and its JSON.
//! * **Invariants:** a claim is shown only if all its evidence exists and passed at the required
//!   extent, with this version and with the present definition of the evidence. Every row of the
//!   fault catalogue belongs to a claim or is listed as not claimed.
//! * **Not included:** the execution of commands; `atas assure --run` starts them.

#![forbid(unsafe_code)]

mod assessment;
mod case;
mod evidence;
mod extent;
mod outcome;
mod page;
mod results;

pub use assessment::{AssessedClaim, AssessedEvidence, Assessment, Problem};
pub use case::{Case, Claim, NotClaimed, Strategy};
pub use evidence::{Evidence, SourceTree};
pub use extent::Extent;
pub use outcome::{Origin, Outcome, from_report, from_tests};
pub use page::{compare_page, page};
pub use results::Results;

/// Folder of the stored results in the source tree.
pub const RESULTS: &str = "clients/assurance/results";
/// Page of the guide in the source tree.
pub const PAGE: &str = "clients/guide/src/assurance.md";
