//! Exit codes: what a script may rely on. This table is the only place that knows them.

use std::fmt;
use std::process::ExitCode;

use atas_client::ClientError;
use shm_bus::BusError;

/// How a command ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Exit {
    /// Done as asked.
    Ok = 0,
    /// Something failed that has no code of its own.
    Failed = 1,
    /// The command line is wrong.
    Usage = 2,
    /// No daemon answers on the bus.
    NoDaemon = 3,
    /// The goal was refused, failed or was cancelled; or the daemon refused the request.
    Refused = 4,
    /// Ctrl-C or SIGTERM, after cleaning up.
    Interrupted = 5,
    /// A demo ran, but an object did not end as physics, or evolution, says it should.
    Unexpected = 6,
}

impl Exit {
    /// The table as users read it, in every `--help`.
    pub const TABLE: &'static str = "\
Exit codes:
  0  done as asked
  1  failed
  2  wrong usage
  3  no daemon answers on the bus
  4  the goal or the request was refused, failed or was cancelled
  5  interrupted, after cleaning up
  6  a demo's object did not end as physics, or evolution, says it should";

    /// The code that an error leads to.
    #[must_use]
    pub fn of(error: &anyhow::Error) -> Self {
        if let Some(ended) = error.downcast_ref::<Ended>() {
            return ended.exit;
        }
        match error.downcast_ref::<ClientError>() {
            Some(ClientError::NoDaemon { .. } | ClientError::Stopped { .. }) => {
                return Self::NoDaemon;
            }
            Some(ClientError::Refused(_)) => return Self::Refused,
            Some(ClientError::Bus(error)) => return Self::of_bus(error),
            _ => {}
        }
        error
            .downcast_ref::<BusError>()
            .map_or(Self::Failed, Self::of_bus)
    }

    fn of_bus(error: &BusError) -> Self {
        match error {
            BusError::Absent { .. }
            | BusError::OtherUser { .. }
            | BusError::NoServer { .. }
            | BusError::ServerGone { .. }
            | BusError::NoAnswer { .. } => Self::NoDaemon,
            _ => Self::Failed,
        }
    }
}

impl From<Exit> for ExitCode {
    fn from(exit: Exit) -> Self {
        Self::from(exit as u8)
    }
}

/// An end with a code of its own and a sentence.
#[derive(Debug)]
pub struct Ended {
    /// The code.
    pub exit: Exit,
    /// One sentence for the user.
    pub sentence: String,
}

impl Ended {
    /// An error with this code and sentence.
    pub fn with(exit: Exit, sentence: impl Into<String>) -> anyhow::Error {
        anyhow::Error::new(Self {
            exit,
            sentence: sentence.into(),
        })
    }
}

impl fmt::Display for Ended {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.sentence)
    }
}

impl std::error::Error for Ended {}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_code_is_in_the_table() {
        let all = [
            Exit::Ok,
            Exit::Failed,
            Exit::Usage,
            Exit::NoDaemon,
            Exit::Refused,
            Exit::Interrupted,
            Exit::Unexpected,
        ];
        let lines: Vec<&str> = Exit::TABLE.lines().skip(1).collect();
        assert_eq!(lines.len(), all.len());
        for (line, exit) in lines.iter().zip(all) {
            assert!(
                line.starts_with(&format!("  {}  ", exit as u8)),
                "{line:?} for {exit:?}"
            );
        }
    }

    #[test]
    fn errors_lead_to_codes() {
        let check = |error: anyhow::Error, exit| assert_eq!(Exit::of(&error), exit, "{error}");
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
        check(Ended::with(Exit::Interrupted, "stopped"), Exit::Interrupted);
        check(anyhow::anyhow!("other"), Exit::Failed);
    }
}
