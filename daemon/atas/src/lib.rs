//! The pure heart of ATAS, the artificial tactile affordance system: what fingertips feel induces the next movement.
//!
//! One call of [`Controller::step`] per tick takes [`Inputs`] (frames, joint state, an order) and gives [`Outputs`] (a
//! joint command, a report, events). In between, data climbs a ladder of types, each of which can only be made in its
//! own file:
//!
//! ```text
//! HandFrame ─ intake ─▶ CheckedFrame ─ perception ─▶ Percept ─ modules ─▶ [Proposal] ─ arbitration ─▶ Intent
//!                                                                                                       │
//!                     JointCommand ◀─ publish ─ SafeCommand ◀─ safety ─ HandCommand ◀─ kinematics ──────┘
//! ```
//!
//! * **Invariants:** the outputs are a function of the inputs so far, bit for bit. No clock, no allocation, no lock, no
//!   I/O, no `unsafe`. Nothing reaches a robot but through the gate in [`safety`]. Modules stand in parallel without
//!   priority: [`arbitration`] does not depend on their order. Doubt leads to HOLD; opening the hand never does.
//! * **Absent on purpose:** threads, time, transport, configuration files (the daemon's), and any knowledge of whether
//!   a robot is real or simulated.
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
