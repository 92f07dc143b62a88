//! Everything that ends a robot process early, and the exit code it ends with.
//!
//! | code | meaning |
//! |---|---|
//! | 0 | stopped by SIGINT or SIGTERM; the servos hold |
//! | 1 | standard output could not be written; a closed pipe is no failure |
//! | 2 | the command line makes no sense, or a file could not be written |
//! | 3 | the servo map makes no sense |
//! | 4 | a servo or its port does not answer as the map says |
//! | 6 | the bus could not be used |
//!
//! The codes are stable: service managers and scripts may act on them. They agree with those of `atas-sensor` where both have
//! the case.

use std::fmt::Write as _;

/// Why a robot process could not go on.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Failure {
    /// Standard output failed.
    #[error("could not write to standard output: {0}")]
    Output(#[source] std::io::Error),
    /// Arguments that contradict each other, or a file that could not be written.
    #[error("{0}")]
    Usage(String),
    /// Everything that is wrong with a servo map.
    #[error("could not use the servo map {file}:{}", listed(findings))]
    Map {
        /// The file that was given.
        file: String,
        /// What is wrong, each with its place.
        findings: Vec<String>,
    },
    /// A servo, or its port, does not answer as the map says.
    #[error("{0}")]
    Servos(String),
    /// The bus refused.
    #[error("{0}")]
    Bus(#[source] shm_bus::BusError),
}

fn listed(findings: &[String]) -> String {
    findings.iter().fold(String::new(), |mut text, finding| {
        // Writing to a string cannot fail.
        let _ = write!(text, "\n  {finding}");
        text
    })
}

impl Failure {
    /// The exit code of what could not be printed.
    pub const UNWRITTEN: u8 = 1;

    /// The exit code that stands for this failure.
    #[must_use]
    pub fn exit_code(&self) -> u8 {
        match self {
            Self::Output(_) => Self::UNWRITTEN,
            Self::Usage(_) => 2,
            Self::Map { .. } => 3,
            Self::Servos(_) => 4,
            Self::Bus(_) => 6,
        }
    }
}
