//! Hybrid demonstration: combines both methods of the paper in one robot. A behaviour table drives
//! the base, modules control the hand.
//!
//! ```text
//!  Host ─ row ─▶ table (10 Hz) ─ wheel levels ─▶ Host ─ base motion ─▶ hand (1 kHz) ─▶ modules
//!                  ▲                                                     │
//!                  └── control owner ◀── Pilot ◀── base and hand state ──┘
//! ```
//!
//! Course: search the object's light and approach it (table), grasp and lift (modules), carry it to
//! the goal's light (table), set it down (modules). Each [`Pilot`] has a [`Coordinator`], a table
//! of phases and their end conditions. While the hand carries the object, the base drives at half
//! speed and the grip is never relaxed.
//!
//! * **In:** a [`HybridPlan`]. **Out:** a [`HybridReport`]. A trial is evaluated as a pick and
//!   place, plus the grip during the drive.
//! * **Two set-ups:** in process (this module), or one process per part on the bus
//!   (`atas demo hybrid`), with the same pilot and [`Host`](sim_backend::course::Host).
//! * **Invariants:** the result depends on the plan only, not on threads or bus. Phases have time
//!   limits. The base acts on the grip by its accelerations only; all other coupling passes through
//!   the coordinator's conditions.
//! * **Not included:** a camera. The pose of an object within reach has the usual errors (±2 mm,
//!   ±5°). A stopped base has no localisation error. Two robots collide as the discs of
//!   [`sim_backend::course`].

mod coordinator;
mod pilot;
mod report;
mod robot;
mod trial;

pub use coordinator::{
    Conditions, ControlOwner, Coordinator, Ended, HandState, HandTask, PHASES, Phase,
};
pub use pilot::{Decision, PhaseTime, Pilot, Reflexes};
pub use report::{DriveReport, HybridPlan, HybridReport};
pub use trial::{HybridTrial, RobotTrial};
