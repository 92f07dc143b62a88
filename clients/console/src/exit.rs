//! Exit codes of errors; errors with an exit code.

use std::fmt;

use atas_client::ClientError;
use shm_bus::BusError;

pub use atas_process::exit::Exit;

/// Returns the exit code of an error.
#[must_use]
pub fn exit_of(error: &anyhow::Error) -> Exit {
    if let Some(ended) = error.downcast_ref::<ExitError>() {
        return ended.exit;
    }
    match error.downcast_ref::<ClientError>() {
        Some(ClientError::NoDaemon { .. } | ClientError::Stopped { .. }) => return Exit::NoDaemon,
        Some(ClientError::Refused(_)) => return Exit::Refused,
        Some(ClientError::Bus(error)) => return exit_of_bus(error),
        _ => {}
    }
    error
        .downcast_ref::<BusError>()
        .map_or(Exit::Failed, exit_of_bus)
}

fn exit_of_bus(error: &BusError) -> Exit {
    match error {
        BusError::Absent { .. }
        | BusError::OtherUser { .. }
        | BusError::NoServer { .. }
        | BusError::ServerGone { .. }
        | BusError::NoAnswer { .. } => Exit::NoDaemon,
        error if error.is_in_use() => Exit::InUse,
        _ => Exit::Bus,
    }
}

/// Error with an exit code.
#[derive(Debug)]
pub struct ExitError {
    /// Exit code.
    pub exit: Exit,
    /// Message for the user.
    pub message: String,
}

impl ExitError {
    /// Creates an error with this exit code and message.
    pub fn with_code(exit: Exit, sentence: impl Into<String>) -> anyhow::Error {
        anyhow::Error::new(Self {
            exit,
            message: sentence.into(),
        })
    }
}

impl fmt::Display for ExitError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.message)
    }
}

impl std::error::Error for ExitError {}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_map_to_exit_codes() {
        let check = |error: anyhow::Error, exit| assert_eq!(exit_of(&error), exit, "{error}");
        let gone = || BusError::ServerGone {
            service: "atas/v1/goal",
        };
        check(gone().into(), Exit::NoDaemon);
        check(ClientError::from(gone()).into(), Exit::NoDaemon);
        check(ClientError::Refused("no".into()).into(), Exit::Refused);
        check(
            anyhow::Error::new(gone()).context("while asking"),
            Exit::NoDaemon,
        );
        check(
            ExitError::with_code(Exit::Interrupted, "stopped"),
            Exit::Interrupted,
        );
        check(anyhow::anyhow!("other"), Exit::Failed);
    }
}
