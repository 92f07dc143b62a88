//! Sensor processes for real tactile hardware.
//!
//! One process reads the devices of one hand and publishes [`HandFrame`](shm_schemas::HandFrame)s:
//!
//! ```text
//! device ─▶ transport ─bytes─▶ wire (driver: decode) ─frames─▶ intake (number) ─▶ port (stamp) ─┐
//! device ─▶ ...                                                           one thread per port ──┤
//!                                                          bus ◀─┬─ hand ◀─────────── readings ─┘
//!                                                        table ◀─┘
//! ```
//!
//! * **Inputs:** serial terminals, UDP peers, WebSocket servers, the command line.
//! * **Outputs:** frames and [`SensorStatus`](shm_schemas::SensorStatus) on the bus, or a table on
//!   standard output; a log on standard error; an [exit code](failure).
//! * **Invariants:** Damage never costs a valid frame, and every byte is counted
//!   (`tests/decoder.rs`, `tests/peers.rs`). Time stamps increase and are never in the future
//!   ([`stamping`]). Sequence numbers keep the device's gaps ([`intake`]). No input makes a parser
//!   panic (`tests/any_bytes.rs`).
//! * **Replay** ([`replay`]): publishes recorded frames.
//! * **Calibration** ([`calibration`]): fitted by `atas calibrate`, applied with
//!   `--calibration FILE`.
//! * **Out of scope:** filtering, thresholds and contact detection (perception in `atas`).
//!
//! A new sensor needs one file in [`wire`], one line in [`wire::SENSORS`], and one table in
//! `tests/vectors/`.

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
