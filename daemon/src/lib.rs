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
//! Exit codes: [`atas_process::exit::Exit`]; 130 or 143 after a second SIGINT or SIGTERM.

pub mod args;
pub mod cache_warm_up;
pub mod config;
pub mod daemon;
pub mod input_log;
pub mod link;
pub mod pacer;
pub mod panic_guard;
mod panics;
pub mod ports;
pub mod realtime;
pub mod statistics;
mod stop_thread;
pub mod supervisor;
pub mod tick;
