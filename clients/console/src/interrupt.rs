//! Ctrl-C and SIGTERM as a flag that long work polls.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use atas_process::shutdown;
use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};

use crate::{Exit, ExitError};

/// Flag that the first signal sets. The second signal ends the process.
#[derive(Clone, Debug, Default)]
pub struct Interrupt(Arc<AtomicBool>);

impl Interrupt {
    /// Installs handlers for SIGINT, SIGTERM and SIGHUP instead of their default action.
    pub fn install() -> anyhow::Result<Self> {
        let flag =
            shutdown::install_stop_flag(&[SIGINT, SIGTERM, SIGHUP], Exit::Interrupted as i32)?;
        Ok(Self(flag))
    }

    /// Returns true after a signal.
    pub fn is_set(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }

    /// Returns the flag, for code without signal handling.
    pub fn flag(&self) -> &AtomicBool {
        &self.0
    }

    /// Returns an error after a signal.
    pub fn check(&self, what: &str) -> anyhow::Result<()> {
        if self.is_set() {
            Err(ExitError::with_code(
                Exit::Interrupted,
                format!("interrupted: {what}"),
            ))
        } else {
            Ok(())
        }
    }
}
