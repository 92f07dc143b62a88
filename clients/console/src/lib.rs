//! What `atas` and `atas-lab` have in common at a terminal: one command line, one way to print, one table of exit codes.
//!
//! Two programs share it so that they are one to their users: `atas` reads every command, does the operator's itself and
//! hands the laboratory's to `atas-lab`. Help, completions and manual pages come from the one table in [`arguments`].
//!
//! * **In:** arguments, `ATAS_BUS`, `NO_COLOR`, `RUST_LOG`, signals. **Out:** results on standard output, progress and errors
//!   on standard error, and an exit code of [`Exit`].
//! * **Invariants:** a reader that goes away ends a command without a word. The first signal asks work to end, the second ends
//!   the process.
//! * **Absent on purpose:** what any command does.

pub mod arguments;
mod exit;
mod interrupt;
mod output;
mod program;
mod progress;

pub use exit::{Ended, Exit};
pub use interrupt::Interrupt;
pub use output::{Format, Mood, Output, modules, number, table, whole};
pub use program::run;
pub use progress::Progress;
