//! Ctrl-C and SIGTERM as a flag that long work looks at.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use atas_process::end;
use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};

use crate::{Ended, Exit};

/// Set by the first signal. The second one ends the process at once.
#[derive(Clone, Debug, Default)]
pub struct Interrupt(Arc<AtomicBool>);

impl Interrupt {
    /// Begins to listen to SIGINT, SIGTERM and SIGHUP instead of dying of them.
    pub fn listen() -> anyhow::Result<Self> {
        let flag = end::on_signals(&[SIGINT, SIGTERM, SIGHUP], Exit::Interrupted as i32)?;
        Ok(Self(flag))
    }

    /// Whether a signal came.
    pub fn is_set(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }

    /// The flag itself, for work that knows nothing of signals.
    pub fn flag(&self) -> &AtomicBool {
        &self.0
    }

    /// An error if a signal came.
    pub fn check(&self, what: &str) -> anyhow::Result<()> {
        if self.is_set() {
            Err(Ended::with(
                Exit::Interrupted,
                format!("interrupted: {what}"),
            ))
        } else {
            Ok(())
        }
    }
}
