//! The whole program in front of servos that are played, and its parts.

mod commands;
mod map;
mod process;
mod rig;
mod robot;
mod trouble;
