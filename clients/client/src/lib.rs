//! A client of a running daemon: joins its bus, asks, follows what it asked for.
//!
//! ```text
//!  Session ─┬─ watch_status, control: one answer
//!           ├─ Pursuit: a goal from its sending to its end ─▶ GoalProgress
//!           ├─ Leader: a goal that opens a stream of targets, and the stream
//!           ├─ Watch: looking on
//!           └─ Run: which robot, which sensors
//!  goal, scenes: what a goal may ask for, and what is usual where nothing is said
//!  standstill: whether the ticks still come, and whether a daemon that says nothing is stopped
//!  json, words, percentiles: what the bus says, for programs and for people
//! ```
//!
//! * **In:** the bus of a daemon. **Out:** answers, progress, errors that say what to do.
//! * **Invariants:** whoever asks waits for the answer, and no longer than a second. Nothing here knows how the daemon
//!   decides: neither the controller nor a simulator is linked.
//! * **Absent on purpose:** the terminal (`atas-console`), and every file.

pub mod account;
mod error;
pub mod goal;
pub mod histogram;
pub mod json;
pub mod layouts;
mod leader;
pub mod percentiles;
mod progress;
mod pursuit;
mod run;
pub mod scenes;
mod session;
mod standstill;
mod watch;
pub mod words;

pub use error::ClientError;
pub use leader::{Leader, Led, Wanted};
pub use progress::GoalProgress;
pub use pursuit::{Cancelled, Pursuit};
pub use run::Run;
pub use session::{POLL, Session};
pub use standstill::{Stopped, standstill};
pub use watch::{Watch, body_ns};
