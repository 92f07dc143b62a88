//! Tests of the daemon from outside: its configuration, and the real binary on a real bus.

mod config;
mod example;
mod goals;
mod kernel;
mod lifecycle;
mod log_output;
mod replay;
mod requests;
mod service;
mod status;
mod stops;
mod support;
mod systemd_units;
mod tasks;
