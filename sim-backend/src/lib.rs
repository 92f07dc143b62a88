//! Simulated world for two tactile hands: fingertips, objects, a table, joints, sensors, faults.
//!
//! ```text
//!  objects/*.toml ─▶ Object ─▶ Scene ─▶ World ──sense──▶ Sensed ─▶ (FaultPipeline) ─▶ controller
//!                                         ▲  └──truth──▶ WorldTruth ─▶ judges             │
//!                                         └─────────────advance(JointCommand)─────────────┘
//! ```
//!
//! **Inputs:** a robot, a [`Scene`], a seed, then one [`JointCommand`](shm_schemas::JointCommand)
//! per millisecond. **Outputs:** the payloads of a real robot ([`Sensed`]) and the ground truth
//! ([`World::truth`]).
//!
//! **One tick** ([`World::advance`]) is four substeps of 250 µs. Each computes the contact of every
//! fingertip (287 elasto-plastic bristles, `contact.rs`), then the joint servos (`plant.rs`), then
//! the objects (`body.rs`).
//!
//! **Invariants:**
//!
//! * Deterministic: no clock, I/O or threads. The same scene, seed and commands give the same bits
//!   on every machine (`tests/grasp.rs`). No fused multiply-add; trigonometry from `libm`.
//! * A damaged, not finite or expired command moves nothing (`tests/world.rs`). Without commands
//!   the joints hold their position and the grip stays (`tests/grasp.rs`).
//! * If a state stops being finite, the world reports [`World::fault`] and freezes.
//! * Simulation does not allocate.
//!
//! **Engines:** [`World::new`] uses the built-in contact model, [`World::with_engine`] an
//! [`engine`] in a process of its own. Then determinism, I/O and allocation depend on that engine.
//!
//! **Further modules:** [`swarm`], the field of methodology 2; [`course`], wheeled bases that carry
//! robots and call [`World::set_base_motion`]; [`Fingertip`], a fingertip under known loads.
//!
//! **Use:** in process in virtual time (tests, `atas eval`), or as the process `atas-sim` on the
//! bus.
//!
//! **Not modelled:** contact of other links; contact of fingertips with each other, the table or
//! plates; contact between objects except a cap and its bottle (`threaded_cap.rs`); rigid-body
//! coupling between joints (see `plant.rs`). A fingertip touches one object at a time, only with
//! its 35° sensing cap.
//!
//! ```
//! use robot_model::{HandSide, RobotModel};
//! use sim_backend::{Object, Scene, Sensed, World};
//!
//! let robot = RobotModel::two_hand_arm()?;
//! let scene = Scene::grasp(Object::built_in("wood")?, HandSide::Right);
//! let mut world = World::new(&robot, &scene, 1)?;
//! let mut sensed = Sensed::default();
//! for _ in 0..10 {
//!     world.sense(&mut sensed);
//!     world.advance(None);
//! }
//! assert_eq!(world.tick(), 10);
//! assert!(world.fault().is_none());
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
#![deny(unsafe_code)]

mod base_motion;
mod body;
mod builtin;
mod clock;
mod contact;
pub mod course;
mod drive;
mod electronics;
mod encoder;
pub mod engine;
mod external;
pub mod faults;
mod fingertip;
mod hand;
mod hand_body;
mod hold;
mod lanes;
mod name;
mod object;
mod pad;
mod plant;
pub mod random;
mod range;
mod scene;
mod sensed_hand;
mod sensor;
mod sensor_model;
mod servo_lag;
mod shape;
mod support;
pub mod swarm;
mod thread;
mod threaded_cap;
mod torsion;
mod vibration;
mod world;
mod world_object;

pub use base_motion::{BaseMotion, BaseMotionError};
pub use body::GRAVITY_M_S2;
pub use clock::{START_NS, TICK_NS};
pub use drive::LATENCY_MS;
pub use electronics::Sensed;
pub use fingertip::Fingertip;
pub use object::{Neck, Object, ObjectError};
pub use pad::{MissingElementPositions, simulated_skin};
pub use range::OutOfRange;
pub use scene::{
    ErrorKind, ErrorSpecError, Errors, GraspHint, Mount, OBJECTS_MAX, Placed, Scene, SceneError,
    SensorErrors, home,
};
pub use sensor::{Creep, Hysteresis};
pub use sensor_model::{
    CreepModel, DeadModel, DeadReading, DriftModel, FrameModel, FrameStamp, HysteresisModel,
    Rejection, SensorModel, SensorModelError, WearModel,
};
pub use shape::Shape;
pub use support::Plate;
pub use thread::{ClosingDirection, Thread};
pub use world::{World, WorldFault};
