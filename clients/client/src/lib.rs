//! Client library of a running daemon: joins its bus, sends requests and goals, reads progress and
//! data.
//!
//! ```text
//!  Session ─┬─ watch_status, control: one answer
//!           ├─ GoalExecution: a goal from sending to its end ─▶ GoalProgress
//!           ├─ TeleopSender: a goal that opens a stream of targets, and the stream
//!           ├─ Observer: observation
//!           └─ Run: robot and sensors
//!  goal, scenes: goal requests, and default positions and sizes
//!  stop: over the stop socket, else over the control service
//!  standstill: detection of stopped ticks and of a suspended daemon
//!  json, text, percentiles: bus data for programs and for people
//!  contact: forces of a fingertip from its elements
//! ```
//!
//! * **Input:** the bus of a daemon. **Outputs:** answers, progress, errors with a remedy.
//! * **Invariants:** a request waits for its answer, at most one second. The crate depends neither
//!   on the controller nor on a simulator.
//! * **Not included:** the terminal (`atas-console`) and files.
//!
//! ```
//! use atas_client::{Session, json};
//! use shm_bus::BusName;
//!
//! # fn print_status() -> Result<(), Box<dyn std::error::Error>> {
//! let session = Session::existing(&BusName::from_env()?)?;
//! let (_statuses, status) = session.watch_status()?;
//! println!("{}", json::status(&status, json::CAPACITY));
//! # Ok(())
//! # }
//! ```

pub mod contact;
mod error;
pub mod goal;
mod goal_execution;
pub mod goal_summary;
pub mod histogram;
pub mod json;
pub mod layouts;
mod observer;
pub mod percentiles;
mod progress;
pub mod rejections;
mod run;
pub mod scenes;
mod session;
mod standstill;
mod stop;
mod teleop;
pub mod text;

pub use error::ClientError;
pub use goal_execution::{Cancelled, GoalExecution};
pub use observer::{Observer, body_ns};
pub use progress::GoalProgress;
pub use run::Run;
pub use session::{POLL, Session};
pub use standstill::{Stopped, standstill};
pub use stop::{StopChannel, StopReply, request_stop};
pub use teleop::{TeleopHands, TeleopSender, TeleopTarget};

/// Tests of the programs in the README.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
