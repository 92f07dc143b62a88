//! The ATAS daemon: the pure controller of crate `atas`, wired to a bus, a clock and a service manager.
//!
//! ```text
//!  HandFrame ×2 ─▶ ┌──────────── tick thread (SCHED_FIFO) ────────────┐
//!  JointState ───▶ │ pacer ─▶ ports ─▶ guard(controller) ─▶ publisher │ ─▶ JointCommand, every tick
//!                  └───────▲ orders ────────────── records │ ─────────┘
//!                          │            (link)             ▼
//!  goals, control ─▶ ┌─────┴──────────── supervisor (main thread) ────┐ ─▶ goal updates, control replies, log,
//!  signals, config ─▶└────────────────────────────────────────────────┘    Status 50 Hz, TickReport, events,
//!                                                                          TickInputs (recording), flight files
//! ```
//!
//! * **In:** a configuration ([`config`]), frames, joint states, goals, control requests, signals.
//!   **Out:** a joint command every tick, and what observers may know.
//! * **Invariants:** one daemon per bus. The tick never waits for the supervisor, nor for any other process. A command
//!   goes out in every tick and every mode. Whatever the kernel refused, was late or was lost is counted and visible.
//!   What is recorded is all that the commands depend on: it replays bit for bit (`tests/daemon/replay.rs`). A tick makes
//!   one system call, its sleep, and no page fault (`tests/daemon/kernel.rs`).
//! * **Absent on purpose:** any decision about motion (crate `atas`), any robot or sensor driver (other processes).
//!
//! # Exit codes
//!
//! | code | meaning |
//! |---|---|
//! | 0 | stopped as asked: SIGTERM or SIGINT, the robot at rest |
//! | 1 | failed while running |
//! | 2 | wrong command line |
//! | 3 | configuration refused |
//! | 4 | another daemon owns the bus |
//! | 5 | the bus could not be opened |
//! | 6 | real time is required and was refused |
//! | 130, 143 | stopped at once by a second SIGINT or SIGTERM, without waiting for the robot |

pub mod args;
pub mod config;
pub mod daemon;
pub mod figures;
pub mod guard;
pub mod input_log;
pub mod link;
pub mod pacer;
mod panics;
pub mod ports;
pub mod realtime;
mod stop_thread;
pub mod supervisor;
pub mod tick;
pub mod warm;
