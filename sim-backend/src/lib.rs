//! A simulated world for two tactile hands.
#![forbid(unsafe_code)]

mod body;
mod contact;
mod drive;
pub mod faults;
mod hand;
mod object;
mod pad;
mod plant;
pub mod random;
mod scene;
mod sensor;
mod shape;
mod thing;
mod vibration;
mod world;

pub use body::GRAVITY_M_S2;
pub use drive::LATENCY_MS;
pub use object::{Object, ObjectError};
pub use plant::servo_stiffness_n_m_rad;
pub use scene::{GraspHint, OBJECTS_MAX, Placed, Scene, SceneError, home_rad};
pub use shape::Shape;
pub use world::{START_NS, Sensed, TICK_NS, World, WorldFault};
