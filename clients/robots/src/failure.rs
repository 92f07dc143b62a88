//! Failures of `atas-robot` and their exit codes.

use std::fmt::Write as _;

use atas_process::exit::Exit;
use shm_bus::BusError;

/// Cause of a failure.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Failure {
    /// Standard output failed.
    #[error("could not write to standard output: {0}")]
    Output(#[source] std::io::Error),
    /// Contradictory arguments, or a file that could not be written.
    #[error("{0}")]
    Usage(String),
    /// All errors of a servo map.
    #[error("could not use the servo map {file}:{}", listed(findings))]
    Map {
        /// Path of the servo map.
        file: String,
        /// Errors, each with its location.
        findings: Vec<String>,
    },
    /// A servo or port does not match the map, or does not reply.
    #[error("{0}")]
    Servos(String),
    /// Bus failure.
    #[error("{0}")]
    Bus(#[source] BusError),
}

fn listed(findings: &[String]) -> String {
    findings.iter().fold(String::new(), |mut text, finding| {
        // Writing to a string cannot fail.
        let _ = write!(text, "\n  {finding}");
        text
    })
}

impl Failure {
    /// Returns the exit code.
    #[must_use]
    pub fn exit_code(&self) -> Exit {
        match self {
            Self::Output(_) => Exit::Failed,
            Self::Usage(_) => Exit::Usage,
            Self::Map { .. } => Exit::Input,
            Self::Servos(_) => Exit::Device,
            Self::Bus(error) if error.is_in_use() => Exit::InUse,
            Self::Bus(_) => Exit::Bus,
        }
    }
}
