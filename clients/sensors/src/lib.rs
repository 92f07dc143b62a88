//! Sensor processes for real tactile hardware.
//!
//! One process reads the devices of one hand and publishes [`HandFrame`](shm_schemas::HandFrame)s:
//!
//! ```text
//! device ─▶ transport ─bytes─▶ wire (driver: decode) ─frames─▶ intake (number) ─▶ port (stamp) ─readings─▶ hand ─▶ bus
//! device ─▶ ...                                                                  one thread per port ─▶      └▶ table
//! ```
//!
//! * **In:** serial terminals, UDP peers, WebSocket servers; the command line. **Out:** frames and
//!   [`SensorStatus`](shm_schemas::SensorStatus) on the bus, or a table on standard output; a log on standard error; an
//!   [exit code](failure).
//! * **Invariants:** no valid frame is lost to damage around it (`tests/decoder.rs`, `tests/peers.rs`); every byte is
//!   accounted for (same places); stamps increase and are never in the future ([`stamping`]); sequences show the
//!   device's own gaps ([`intake`]); nothing that a device sends makes a parser panic (`tests/any_bytes.rs`).
//! * **Replay** ([`replay`]): recorded frames instead of a device's, on the same way to the bus.
//! * **Calibration** ([`calibration`]) is fitted by `atas calibrate` and applied here: `--calibration FILE`.
//! * **Absent on purpose:** filtering, thresholds and any judgement about touch: that is perception, in `atas`.
//!
//! A further sensor is one file in [`wire`] with its format, one line in [`wire::SENSORS`], and one table of test vectors
//! in `tests/vectors/`.

pub mod calibration;
pub mod cli;
pub mod commands;
pub mod continuity;
pub mod failure;
pub mod hand;
pub mod intake;
pub mod mapping;
pub mod newtons;
pub mod plan;
pub mod port;
pub mod reading;
pub mod replay;
pub mod resync;
pub mod stamping;
pub mod table;
pub mod transport;
pub mod wire;
pub mod writer;
