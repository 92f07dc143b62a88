//! The daemon from outside: its configuration, and the real binary on a real bus.

mod config;
mod example;
mod goals;
mod kernel;
mod lives;
mod replay;
mod service;
mod support;
mod tasks;
mod unit;
