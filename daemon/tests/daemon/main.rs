//! Tests of the daemon from outside: its configuration, and the real binary on a real bus.

mod config;
mod example;
mod goals;
mod kernel;
mod lives;
mod orders;
mod outputs;
mod replay;
mod service;
mod status;
mod stops;
mod support;
mod tasks;
mod unit;
