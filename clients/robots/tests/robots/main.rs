//! Tests of `atas-robot` with emulated servos, and of its parts.

mod commands;
mod failures;
mod map;
mod process;
mod rig;
mod robot;
