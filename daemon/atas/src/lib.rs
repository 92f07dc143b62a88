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
//!
//! ```
//! use atas_core::{Controller, Inputs, SensorSetup, Settings, Tick};
//! use robot_model::RobotModel;
//! use shm_schemas::Mode;
//!
//! let robot = RobotModel::two_hand_arm()?;
//! let mut controller = Controller::new(&robot, SensorSetup::default(), Settings::default());
//! let tick = Tick { index: 0, now_ns: 1_000_000 };
//! let outputs = controller.step(&Inputs { tick, ..Inputs::default() });
//! // Without frames and joint states the controller waits and moves nothing.
//! assert_eq!(outputs.command.mode, Mode::INIT);
//! # Ok::<(), robot_model::ModelError>(())
//! ```
#![no_std]
#![forbid(unsafe_code)]

pub mod arbitration;
pub mod check;
mod controller;
pub mod executor;
mod filter;
pub mod goal;
mod hand;
pub mod held_object;
pub mod intake;
pub mod io;
pub mod joints;
pub mod kinematics;
pub mod limits;
mod load_sharing;
mod mode;
pub mod modules;
pub mod path;
pub mod perception;
pub mod planning;
pub mod record;
pub mod safety;
mod sensor_setup;
#[cfg(feature = "serde")]
mod serde_arrays;
pub mod settings;
pub mod tasks;
pub mod teleop;
pub mod thresholds;
mod tick;

/// Version of the controller: that of the package, and a number that grows whenever equal inputs
/// give other commands. Recordings carry it.
pub const VERSION: &str = concat!(env!("CARGO_PKG_VERSION"), "+controller.5");

pub use controller::Controller;
pub use goal::Goal;
pub use io::{Events, Inputs, OperatorRequest, Outputs};
pub use mode::ModeMachine;
pub use sensor_setup::{HandSensorSetup, SensorSetup};
pub use settings::Settings;
pub use tick::{Stage, Tick};

/// Tests of the programs in the README.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
