//! Optional reference programs, and notes about those that are missing.

use std::io::{ErrorKind, Write};
use std::path::Path;
use std::process::ExitStatus;
use std::time::{Duration, Instant};

use atas_console::Interrupt;

use atas_processes::child::Child;

const POLL_INTERVAL: Duration = Duration::from_millis(10);

/// Figures that were not measured with their reasons, without duplicates.
#[derive(Debug, Default)]
pub(super) struct Notes(pub(super) Vec<String>);

impl Notes {
    /// Adds a note and prints it once.
    pub(super) fn add(&mut self, text: String) {
        if !self.0.contains(&text) {
            self.progress(&text);
            self.0.push(text);
        }
    }

    pub(super) fn progress(&self, text: impl std::fmt::Display) {
        let _ = writeln!(std::io::stderr(), "bench: {text}");
    }
}

/// Starts an installed program; returns `None` and adds a note if it is missing.
pub(super) fn start(
    program: &Path,
    name: &'static str,
    hint: &str,
    arguments: &[&str],
    folder: &Path,
    notes: &mut Notes,
) -> anyhow::Result<Option<Child>> {
    let started = Child::start_program(program, name, arguments, folder);
    let is_missing = |error: &anyhow::Error| {
        let io = error.downcast_ref::<std::io::Error>();
        io.is_some_and(|io| io.kind() == ErrorKind::NotFound)
    };
    match started {
        Ok(child) => Ok(Some(child)),
        Err(error) if is_missing(&error) => {
            notes.add(format!("{name} was not found; {hint}"));
            Ok(None)
        }
        Err(error) => Err(error),
    }
}

pub(super) fn wait(
    child: &mut Child,
    limit: Duration,
    interrupt: &Interrupt,
) -> anyhow::Result<ExitStatus> {
    let begin = Instant::now();
    loop {
        if let Some(status) = child.exit_status()? {
            return Ok(status);
        }
        interrupt.check("the bench was measuring")?;
        anyhow::ensure!(
            begin.elapsed() < limit,
            "a program of the bench (pid {}) did not end within {limit:?}",
            child.pid()
        );
        std::thread::sleep(POLL_INTERVAL);
    }
}
