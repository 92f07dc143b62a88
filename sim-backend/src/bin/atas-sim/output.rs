//! Standard output: in which form, and what becomes of it where nobody reads.

use std::io::{self, ErrorKind, Write};

use clap::ValueEnum;

use crate::failure::Failure;

/// How results are printed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Format {
    /// For people.
    Human,
    /// For programs: one JSON object per line.
    Json,
}

/// Writes lines to standard output.
pub(crate) fn print(lines: &[String]) -> Result<(), Failure> {
    let text: String = lines.iter().map(|line| format!("{line}\n")).collect();
    write(text.as_bytes())
}

/// A reader that has seen enough closes the pipe; that is no failure. A full disk is one.
pub(crate) fn write(bytes: &[u8]) -> Result<(), Failure> {
    let mut stdout = io::stdout().lock();
    match stdout.write_all(bytes).and_then(|()| stdout.flush()) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => Err(Failure::Output(error)),
        _ => Ok(()),
    }
}
