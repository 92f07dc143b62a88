//! Terminal interface shared by the `atas` programs: command line, output, progress and exit codes.
//!
//! Users see one program. `atas` parses all commands, executes those of the operator and passes the
//! others to `atas-lab` or `atas-live`. Help, completions and manual pages come from [`arguments`].
//!
//! * **Inputs:** arguments, `ATAS_BUS`, `NO_COLOR`, `RUST_LOG`, signals.
//! * **Outputs:** results on standard output, progress and errors on standard error, an exit code
//!   of [`Exit`].
//! * **Invariants:** a closed output pipe ends a command without an error. The first signal
//!   requests the end of the work, the second one ends the process.
//! * **Not included:** the commands themselves, except the stop, which two programs send.

pub mod arguments;
pub mod estop;
mod exit;
mod fetched;
mod interrupt;
mod output;
mod program;
mod progress;

pub use exit::{Exit, ExitError, exit_of};
pub use fetched::print_fetched;
pub use interrupt::Interrupt;
pub use output::{Format, Output, Rating, modules, no_break, number, table};
pub use program::{run, run_any};
pub use progress::Progress;
