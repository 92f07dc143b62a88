//! Sensor processes for real tactile hardware.
//!
//! One process reads one device and publishes one [`HandFrame`](shm_schemas::HandFrame) per device frame:
//!
//! ```text
//! device ─bytes─▶ wire (decode) ─frames─▶ intake (number) ─▶ driver (stamp) ─readings─▶ output (bus or table)
//! ```
//!
//! * **In:** a serial device; the command line. **Out:** frames and [`SensorStatus`](shm_schemas::SensorStatus) on the
//!   bus, or a table on standard output; a log on standard error; an [exit code](failure).
//! * **Invariants:** no valid frame is lost to damage around it (`tests/decoder.rs`); every byte is accounted for (same
//!   place); stamps increase and are never in the future ([`stamping`]); sequences show the device's own gaps
//!   ([`intake`]).
//! * **Absent on purpose:** filtering, thresholds and any judgement about touch: that is perception, in `atas`.
//!
//! A further sensor adds a decoder in [`wire`], a driver, and a variant of [`cli::Sensor`].

pub mod cli;
pub mod device;
pub mod driver;
pub mod failure;
pub mod intake;
pub mod mapping;
pub mod output;
pub mod stamping;
pub mod wire;
