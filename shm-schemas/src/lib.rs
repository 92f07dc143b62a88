//! Payloads of the bus.
//!
//! This crate declares every payload that crosses a process boundary, with its units, capacity and
//! entry in the [service table](service). Sensor drivers, robot drivers, the daemon and clients
//! share only this crate.
//!
//! * **Input, output:** none; the crate contains definitions only.
//! * **Invariants:** payloads are `#[repr(C)]`, of fixed size, without padding and pointers, and
//!   consist of `f32`, `f64`, `u32`, `u64` and `u8` arrays only, so that any language can declare
//!   them. Type names carry a version; a changed layout needs a new version. The golden file
//!   `tests/schemas/layout.golden` pins every size and offset.
//! * **Conventions:** SI units, given as the suffix of each name. Times are nanoseconds of
//!   `CLOCK_MONOTONIC`, or of virtual time in lock-step. Hand 0 is left, hand 1 is right. Joints:
//!   11 left, then 11 right, in URDF order.
//! * **Not included:** transport (`shm-bus`), allocation, clocks, and behaviour other than
//!   validation ([`CommandValidator`]) and formatting.
//!
//! ```
//! use shm_schemas::{Hand, HandFrame, Layout};
//!
//! let mut frame = HandFrame {
//!     hand: Hand::RIGHT,
//!     finger_count: 2,
//!     layout_hash: Layout::dome_41().hash(),
//!     ..HandFrame::default()
//! };
//! frame.force_n[0][0] = [1.5, 0.0, 0.2];
//! frame.seal();
//! assert!(frame.is_intact());
//! frame.force_n[0][0][0] = 9.0;
//! assert!(!frame.is_intact(), "a changed byte breaks the checksum");
//! ```
#![no_std]
#![forbid(unsafe_code)]

#[cfg(test)]
extern crate std;

mod arena;
mod base;
mod body;
#[cfg(feature = "serde")]
mod bytes;
pub mod capacity;
pub mod catalogue;
mod cause;
mod code;
mod command_validation;
mod control;
mod crc;
mod event;
mod fields;
mod frame;
mod goal;
mod joints;
pub mod layout;
mod module;
mod payload;
mod reason;
mod reason_parts;
mod reason_record;
mod reason_text;
mod record;
pub mod schema;
mod sensor_bit;
pub mod service;
mod stamp;
mod status;
mod stop;
mod swarm;
mod target;
mod text;
mod tick;
mod truth;
mod view;
mod wire_value;

pub use arena::{AgentTruth, ArenaTruth, FieldTruth, PostTruth, TrialTruth, WallTruth};
pub use base::{BaseCommand, BaseState, ControlOwner, Light, Mishap};
pub use body::{Body, BodyPair};
pub use cause::Cause;
pub use command_validation::{Accepted, CommandValidator, JointSetpoints};
pub use control::{ControlOp, ControlOutcome, ControlReply, ControlRequest};
pub use event::{EventKind, ModuleEvent};
pub use fields::{GoalField, TargetField};
pub use frame::HandFrame;
pub use goal::{GoalKind, GoalPolicy, GoalRequest, GoalState, GoalUpdate, GraspFigures, Turn};
pub use joints::{JointCommand, JointState, Mode};
pub use layout::Layout;
pub use module::ModuleId;
pub use payload::Payload;
pub use reason::Reason;
pub use reason_parts::JointLabel;
pub use reason_record::ReasonRecord;
pub use reason_text::ReasonText;
pub use record::{
    HandWiringRecord, OrderKind, OrderRecord, RunHeader, SettingsRecord, StepRecord, TableRecord,
    TaskRecord, TickInputs, TrackRecord,
};
pub use sensor_bit::SensorBit;
pub use stamp::{Hand, Stamp};
pub use status::{HandStatus, JointStatus, Percentiles, SensorStatus, Status, StatusFlags};
pub use stop::{StopAnswer, StopOutcome, StopRequest};
pub use swarm::{AgentSensors, WheelCommands};
pub use target::{GraspTarget, GripOrder};
pub use text::Text;
pub use tick::{FingerReport, HandReport, TickReport};
pub use truth::{ObjectTruth, WorldTruth};
pub use view::View;

/// Tests of the programs in the README.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
