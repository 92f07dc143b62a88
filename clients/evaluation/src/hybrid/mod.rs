//! Both methodologies of the paper in one robot: a behaviour table drives its base, modules move its hand.
//!
//! ```text
//!  Host ─ row ─▶ table (10 Hz) ─ wheel levels ─▶ Host ─ ride ─▶ world of the hand (1 kHz) ─▶ modules
//!                  ▲                                                     │
//!                  └── who has the say? ◀── Pilot ◀── seen, felt ────────┘
//! ```
//!
//! The course: search the object of light, come within reach (table), grasp and lift (modules), carry it to the goal of light
//! (table), set it down there (modules). A [`Pilot`] asks its [`Coordinator`], which is a table, too: of phases, and of signs that end
//! them. While the
//! hand has the object, the base drives at half its pace, and the hand gives no force back.
//!
//! * **In:** a [`HybridPlan`]. **Out:** a [`HybridReport`]. A trial is judged as pick and place is, and by how the grip fared on
//!   the way.
//! * **Two ways to run it:** in process, here; or every part a process on the bus (`atas demo hybrid`), with the same pilot and the
//!   same [`Host`](sim_backend::course::Host).
//! * **Invariants:** a function of the plan, whatever the number of threads, and the same bits over the bus. Every trial ends: each phase has a limit of time. The
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
pub use pilot::{Decision, PhaseTime, Pilot, Reflexes};
pub use report::{DriveReport, HybridPlan, HybridReport};
pub use trial::{HybridTrial, RobotTrial};
