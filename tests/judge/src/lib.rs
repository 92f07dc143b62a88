//! Independent judge of a controller.
//!
//! ```text
//!  joint limits ───────────────┐
//!  JointCommand (every tick) ──┼─▶ Judge ─▶ violations: tick, kind, text
//!  WorldTruth   (every tick) ──┘     ▲
//!  test: restart, recovery, promise ─┘
//! ```
//!
//! * **In:** the published commands, the simulator's ground truth, and the events of the test.
//!   **Out:** violations, each with value and limit.
//! * **Invariants:** the crate shares no code with the controller and computes its own differences.
//!   Every check treats a value that is not finite as a violation. Memory is bounded.
//! * **Not included:** reading the bus, and measured joint positions. Therefore following errors
//!   are not judged.
//!
//! One command is one tick period for all differences, at any captured time. A controller that
//! misses a tick must not make up for it. After a command has expired, the robot rests.
//!
//! ```
//! use atas_judge::{JointBounds, JointUnit, Judge};
//! use shm_schemas::{JointCommand, WorldTruth};
//!
//! let elbow = JointBounds {
//!     name: "elbow".to_owned(),
//!     unit: JointUnit::Radian,
//!     lower: -1.5,
//!     upper: 1.5,
//!     speed_max: 2.0,
//!     acceleration_max: 60.0,
//!     jerk_max: 30_000.0,
//! };
//! let mut judge = Judge::new(vec![elbow], 1_000_000, 5_000_000)?;
//! judge.observe(&JointCommand::default(), &WorldTruth::default());
//! assert_eq!(judge.violations()[0].text, "the checksum does not match the content");
//! # Ok::<(), atas_judge::BoundsError>(())
//! ```

#![forbid(unsafe_code)]

mod allowance;
mod bounds;
mod content;
mod findings;
mod grip;
mod joint_motion;
mod judge;
mod modes;
mod motion;
mod objects;
mod promise;
mod rest;
mod stamps;

pub use allowance::Allowance;
pub use bounds::{BoundsError, JointBounds, JointUnit};
pub use findings::{KEPT_PER_KIND, Violation, ViolationKind};
pub use grip::{GRIP_SLIP_MAX_M, GRIP_TURN_MAX_RAD, GripError};
pub use judge::Judge;
pub use motion::RESTART_MARGIN;
pub use promise::Promise;
pub use rest::SETTLE_TICKS;
