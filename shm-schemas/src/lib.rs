//! The payloads on the bus.
//!
//! Every payload that crosses a process boundary is declared here, with its units, its capacity and its place
//! in the [service table](service). A sensor driver, a robot driver, the daemon and every client agree on this
//! crate and on nothing else.
//!
//! * **In, out:** nothing flows through this crate; it only names what flows.
//! * **Invariants:** payloads are `#[repr(C)]`, fixed size, free of padding and pointers, and made of `f32`, `f64`,
//!   `u32`, `u64` and `u8` arrays only, so that any language can declare them. Their type name carries a version;
//!   a changed layout is a new version. The golden file `tests/schemas/layout.golden` pins every size and offset.
//! * **Conventions:** SI units, stated last in each name. Times are nanoseconds of `CLOCK_MONOTONIC` (of virtual
//!   time in lock-step). Hand 0 is left, hand 1 is right. Joints: left 11, then right 11, in the order of the URDF.
//! * **Absent on purpose:** transport (that is `shm-bus`), allocation, clocks, and any behaviour beyond checking
//!   and printing the payloads themselves; which commands a robot obeys ([`Obedience`]) is such a check.
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
mod code;
mod control;
mod crc;
mod event;
mod frame;
mod goal;
mod joints;
pub mod layout;
mod module;
mod obedience;
mod payload;
mod reason;
mod record;
pub mod schema;
mod sensor_bit;
mod sentence;
pub mod service;
mod stamp;
mod status;
mod stop;
mod swarm;
mod target;
mod target_sentence;
mod text;
mod tick;
mod truth;
mod typed;
mod view;

pub use arena::{AgentTruth, ArenaTruth, FieldTruth, PostTruth, TrialTruth, WallTruth};
pub use base::{BaseCommand, BaseState, Light, Mishap, Say};
pub use body::{Body, BodyPair};
pub use control::{ControlOp, ControlOutcome, ControlReply, ControlRequest};
pub use event::{EventKind, ModuleEvent};
pub use frame::HandFrame;
pub use goal::{GoalKind, GoalPolicy, GoalRequest, GoalState, GoalUpdate, GraspFigures, Turn};
pub use joints::{JointCommand, JointState, Mode};
pub use layout::Layout;
pub use module::ModuleId;
pub use obedience::{Accepted, Obedience, Orders};
pub use payload::Payload;
pub use reason::{Cause, Reason};
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
