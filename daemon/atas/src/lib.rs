//! Core of ATAS, the artificial tactile affordance system: a tactile robot controller as a pure
//! function.
//!
//! [`Controller::step`] runs once per tick. It takes [`Inputs`] (tactile frames, joint state,
//! operator request) and returns [`Outputs`] (joint command, report, events). Data passes through a
//! chain of types, each constructed in one file only:
//!
//! ```text
//! HandFrame ─ intake ─▶ ValidatedFrame ─ perception ─▶ Percept ─ modules ─▶ [Proposal] ─┐
//!                                                                                       │
//!    HandCommand ◀─ kinematics ─ Intent ◀─ arbitration ─────────────────────────────────┘
//!         │
//!         └─ safety ─▶ SafeCommand ─ publish ─▶ JointCommand
//! ```
//!
//! * **Invariants:** outputs depend bit for bit on past and present inputs only. No clock,
//!   allocation, lock, I/O or `unsafe`. Every command passes the gate in [`safety`]. Modules run in
//!   parallel without priority: [`arbitration`] does not depend on their order. Faults lead to
//!   HOLD; opening the hand is never a fault reaction.
//! * **Out of scope:** threads, time, transport and configuration files (the daemon's part), and
//!   the difference between a real and a simulated robot.
#![no_std]
#![forbid(unsafe_code)]

pub mod arbitration;
pub mod check;
mod controller;
mod filter;
pub mod follow;
pub mod goal;
mod hand;
pub mod intake;
pub mod io;
pub mod joints;
pub mod kinematics;
#[cfg(feature = "serde")]
mod large;
pub mod limits;
mod mode;
pub mod modules;
pub mod path;
pub mod perception;
pub mod planning;
pub mod record;
pub mod runner;
pub mod safety;
pub mod settings;
mod sharing;
pub mod tasks;
pub mod thresholds;
mod tick;
mod wiring;

pub use controller::Controller;
pub use goal::Goal;
pub use io::{Events, Inputs, Order, Outputs};
pub use mode::ModeMachine;
pub use settings::Settings;
pub use tick::{Stage, Tick};
pub use wiring::{HandWiring, Wiring};
