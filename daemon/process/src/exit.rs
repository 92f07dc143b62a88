//! Exit codes of all programs, part of the interface for scripts and service managers.

use std::process::ExitCode;

/// Exit code of a program; a code has the same meaning in every program.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Exit {
    /// Success.
    Ok = 0,
    /// Failure without a specific code, for example output that could not be written.
    Failed = 1,
    /// Invalid command line.
    Usage = 2,
    /// No daemon answers on the bus.
    NoDaemon = 3,
    /// The goal was rejected, failed or was cancelled; or the daemon rejected the request.
    Refused = 4,
    /// SIGINT or SIGTERM before the work was complete, after clean-up.
    Interrupted = 5,
    /// A demo finished, but an object did not end as physics or evolution predicts.
    Unexpected = 6,
    /// An input was rejected: a file (configuration, robot, servo map, table, recording), or a
    /// value that does not fit it.
    Input = 7,
    /// Another process uses the bus, the hand or the folder.
    InUse = 8,
    /// The bus could not be opened or failed.
    Bus = 9,
    /// Real time is required but not available.
    Realtime = 10,
    /// A sensor or servo could not be opened, does not answer, or was lost.
    Device = 11,
}

impl Exit {
    /// All codes, in order.
    pub const ALL: [Self; 12] = [
        Self::Ok,
        Self::Failed,
        Self::Usage,
        Self::NoDaemon,
        Self::Refused,
        Self::Interrupted,
        Self::Unexpected,
        Self::Input,
        Self::InUse,
        Self::Bus,
        Self::Realtime,
        Self::Device,
    ];

    /// Table for users, part of the `--help` of every program.
    pub const TABLE: &'static str = "\
Exit codes (of all programs):
  0   success, or ended by a signal as intended
  1   failed
  2   invalid command line
  3   no daemon answers on the bus
  4   the goal or request was rejected, failed or was cancelled
  5   interrupted, after clean-up
  6   a demo's object did not end as physics or evolution predicts
  7   an input was rejected: configuration, robot, servo map, table, recording, or a value for it
  8   another process uses the bus, the hand or the folder
  9   the bus could not be opened or failed
  10  real time is required but not available
  11  a sensor or servo could not be opened, does not answer, or was lost";

    /// Returns the code.
    #[must_use]
    pub const fn code(self) -> u8 {
        self as u8
    }
}

impl From<Exit> for ExitCode {
    fn from(exit: Exit) -> Self {
        Self::from(exit.code())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn table_lists_every_exit_code() {
        let lines: Vec<&str> = Exit::TABLE.lines().skip(1).collect();
        assert_eq!(lines.len(), Exit::ALL.len());
        for (line, exit) in lines.iter().zip(Exit::ALL) {
            let code = line.split_whitespace().next();
            assert_eq!(code, Some(exit.code().to_string().as_str()), "{exit:?}");
        }
    }
}
