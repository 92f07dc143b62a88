//! Both methodologies of the paper in one robot: a behaviour table drives its base, modules move its hand.
//!
//! ```text
//!  Course ─ row ─▶ table (10 Hz) ─ wheel levels ─▶ Course ─ ride ─▶ world of the hand (1 kHz) ─▶ modules
//!                    ▲                                                         │
//!                    └── who has the say? ◀── Coordinator ◀── seen, felt ──────┘
//! ```
//!
//! The course: search the object of light, come within reach (table), grasp and lift (modules), carry it to the goal of light
//! (table), set it down there (modules). The [`Coordinator`] is a table, too: of phases, and of signs that end them. While the
//! hand has the object, the base drives at half its pace, and the hand gives no force back.
//!
//! * **In:** a [`HybridPlan`]. **Out:** a [`HybridReport`]. A trial is judged as pick and place is, and by how the grip fared on
//!   the way.
//! * **Invariants:** a function of the plan, whatever the number of threads. Every trial ends: each phase has a limit of time. The
//!   base's accelerations load the grip; nothing else passes between both sides but what the coordinator sees and feels. What
//!   goes wrong is named and counted, and the robot stands.
//! * **Absent on purpose:** a camera. Where an object within reach stands is told with the errors of every other evaluation: ±2 mm and
//!   ±5°. A base that has stopped stands where it believes; arms of two robots meet only as the discs that [`sim_backend::course`] knows.

mod coordinator;
mod pilot;
mod report;
mod robot;
mod trial;

pub use coordinator::{Coordinator, Ended, HandState, HandTask, PHASES, Phase, Say, Signs};
pub use pilot::{Decision, Pilot, Reflexes};
pub use report::{DriveReport, HybridPlan, HybridReport};
pub use trial::{HybridTrial, PhaseTime, RobotTrial};
