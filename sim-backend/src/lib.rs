//! A simulated world for two tactile hands: fingertips, objects, a table, joints, sensors, faults.
//!
//! ```text
//!  objects/*.toml ─▶ Object ─▶ Scene ─▶ World ──sense──▶ Sensed {frames, joints} ─▶ (Injector) ─▶ controller or bus
//!                                         ▲  └──truth──▶ WorldTruth ─▶ judges            │
//!                                         └─────────────advance(JointCommand)────────────┘
//! ```
//!
//! * **In:** a robot, a [`Scene`], a seed, then one [`JointCommand`](shm_schemas::JointCommand) per millisecond.
//!   **Out:** what a real robot would publish ([`Sensed`]), and what only a judge may see ([`World::truth`]).
//! * **One millisecond** ([`World::advance`]) is four substeps of 250 µs. In each, every fingertip near an object feels it
//!   (a bed of 287 elasto-plastic bristles, see `contact.rs`), the joints follow their servos against that force
//!   (`plant.rs`), and the objects follow theirs (`body.rs`).
//! * **Invariants**
//!   * Deterministic: no clock, no I/O, no threads, randomness only from the seed; the same scene, seed and commands give
//!     the same bits on every machine (`tests/grasp.rs`). No fused multiply-add, trigonometry from `libm`.
//!   * A command that is damaged, not finite or expired moves nothing (`tests/world.rs`); without commands the joints
//!     hold, and the grip stays (`tests/grasp.rs`).
//!   * Whatever is commanded, the world stays finite; if it ever does not, it says so ([`World::fault`]) and stands still.
//!   * Simulating allocates nothing.
//! * **Beside it:** [`swarm`], the field of methodology 2 as its host runs it, frame by frame; [`course`], a field with wheeled
//!   bases that carry robots: how a base moves is told to the world of its robot ([`World::ride`]); a [`Fingertip`] off its hand,
//!   under loads that are known.
//! * **Two ways to use it:** in process, in virtual time (tests, `atas eval`), or as the process `atas-sim` on the bus.
//! * **Absent on purpose:** contact of links other than the fingertips, of fingertips with each other and with the table,
//!   and of objects with each other, but for a cap and its bottle (`closure.rs`); fingertips do not feel plates; rigid-body coupling between joints (the servos hide it, see `plant.rs`). A fingertip
//!   touches one object at a time and has no skin beyond its 35° sensing cap.
#![deny(unsafe_code)]

mod body;
mod clock;
mod closure;
mod contact;
pub mod course;
mod drive;
mod encoder;
pub mod faults;
mod fingertip;
mod hand;
mod hold;
mod lanes;
mod object;
mod pad;
mod plant;
pub mod random;
mod range;
mod ride;
mod scene;
mod sensor;
mod shape;
mod support;
pub mod swarm;
mod thread;
mod torsion;
mod vibration;
mod world;
mod world_object;

pub use body::GRAVITY_M_S2;
pub use clock::{START_NS, TICK_NS};
pub use drive::LATENCY_MS;
pub use fingertip::Fingertip;
pub use object::{Neck, Object, ObjectError};
pub use pad::{NoPlaces, simulated_skin};
pub use range::OutOfRange;
pub use ride::Ride;
pub use scene::{
    ErrorKind, ErrorSpecError, Errors, GraspHint, Mount, OBJECTS_MAX, Placed, Scene, SceneError,
    home_rad,
};
pub use shape::Shape;
pub use support::Plate;
pub use thread::{Thread, Turn};
pub use world::{Sensed, World, WorldFault};
