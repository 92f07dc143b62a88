//! The ATAS daemon: connects the pure controller of crate `atas` to a bus, a clock and a service
//! manager.
//!
//! ```text
//!  HandFrame ×2 ─▶ ┌──────── tick thread (SCHED_FIFO) ─────────┐
//!  JointState ───▶ │ pacer ─▶ ports ─▶ controller ─▶ publisher │ ─▶ JointCommand, every tick
//!                  └────▲ requests ───────────── records │ ────┘
//!                       │              (link)            ▼
//!  goals, control ─▶ ┌──┴──────── supervisor (main thread) ──┐ ─▶ goal updates, replies, log,
//!  signals, config ─▶└───────────────────────────────────────┘    Status 50 Hz, TickReport,
//!                                                                 events, TickInputs, flight files
//! ```
//!
//! **In:** a configuration ([`config`]), frames, joint states, goals, control requests, signals.
//! **Out:** a joint command every tick, and telemetry.
//!
//! Invariants:
//! * One daemon per bus.
//! * The tick never waits for the supervisor or another process.
//! * The daemon publishes a command in every tick and every mode.
//! * Refusals of the kernel, late ticks and losses are counted and visible.
//! * The recorded inputs determine the commands: a replay is bit-exact (`tests/daemon/replay.rs`).
//! * A tick makes one system call, its sleep, and no page fault (`tests/daemon/kernel.rs`).
//!
//! Decisions about motion are in crate `atas`; robot and sensor drivers are separate processes.
//!
//! # Exit codes
//!
//! | code | meaning |
//! |---|---|
//! | 0 | ended by SIGTERM or SIGINT, the robot at rest |
//! | 1 | failed while running |
//! | 2 | wrong command line |
//! | 3 | configuration rejected |
//! | 4 | another daemon owns the bus |
//! | 5 | the bus could not be opened |
//! | 6 | real time is required but not available |
//! | 130, 143 | ended at once by a second SIGINT or SIGTERM |

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
