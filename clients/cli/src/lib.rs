//! The command line of ATAS, as a library so that tests and benches can call what the commands call.
//!
//! ```text
//!  arguments ─▶ commands ─┬─ client ──▶ goals, control, status, events of a running daemon (over the bus)
//!                         ├─ demo ────▶ starts atasd and atas-sim on a fresh bus, sends the goal, judges by the truth
//!                         ├─ eval ────▶ rehearsal: controller and world in process, in virtual time, on all cores
//!                         │              └─▶ judge: what physics allows, and what became of it
//!                         └─ plot ────▶ rehearsal, tick by tick, as a figure
//! ```
//!
//! * **In:** arguments, `ATAS_BUS`, `NO_COLOR`. **Out:** results on standard output, progress and errors on standard
//!   error, and an exit code of [`exit::Exit`].
//! * **Invariants:** a command that asks something of a daemon waits for its answer. Without a daemon it ends within
//!   one second, with a code of its own. Ctrl-C leaves neither a process nor a bus behind that the command started.
//!   The numbers of `eval` and the bytes of `plot` depend on its arguments only, not on the threads; times do.
//! * **Absent on purpose:** control, perception and limits (the daemon's), and any knowledge of which object of the
//!   built-in set can be held: [`judge`] computes it.

pub mod arguments;
mod bench;
mod client;
mod commands;
mod demo;
mod doctor;
pub mod eval;
pub mod exit;
mod fifo;
mod figures;
mod interrupt;
mod json;
pub mod judge;
mod nominal;
mod output;
pub mod plot;
mod progress;
mod recording;
pub mod rehearsal;
pub mod story;

pub use commands::main;
