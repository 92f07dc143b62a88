//! ROS 2 interfaces of the bridge: messages, services and actions as Rust types.
//!
//! | file | interfaces |
//! |---|---|
//! | `standard` | packages of a ROS 2 installation |
//! | `gripper`, `parameters` | the gripper actions, and parameters of nodes |
//! | `atas` | package `atas_msgs` (`clients/ros2/atas_msgs`) |
//! | `action` | the messages that the action protocol derives from an action |
//! | `describe` | type descriptions and type hashes |

pub mod action;
pub mod atas;
pub mod catalogue;
mod describe;
pub mod gripper;
pub mod parameters;
pub mod standard;

pub use action::Action;
pub use describe::{
    Bounded, Byte, Field, FieldType, Fields, Message, Nested, Service, message_hash, service_hash,
};
pub(crate) use describe::{messages, services};
