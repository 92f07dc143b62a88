//! Tests of the pure heart through its public API: every rung of the ladder alone, then the whole controller.

mod arbitration;
mod bench;
mod clearance;
mod controller;
mod determinism;
mod faults;
mod gate;
mod goal;
mod hardness;
mod intake;
mod intake_series;
mod joints;
mod lift_proof;
mod mode;
mod modules;
mod path;
mod perception;
mod placing;
mod reaction;
mod rig;
mod rules;
mod screwing;
mod settings;
mod support;
mod tasks;
mod world;
