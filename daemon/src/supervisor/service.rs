//! Interface to the service manager and to signals.

use std::io;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use atas_process::fatal_signals;
use sd_notify::NotifyState;
use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};
use signal_hook::flag;

/// Requests by signal: SIGTERM and SIGINT stop (a second one at once), SIGHUP reloads the
/// configuration.
#[derive(Clone, Debug, Default)]
pub struct Signals {
    stop: Arc<AtomicBool>,
    reload: Arc<AtomicBool>,
}

impl Signals {
    /// Installs the handlers.
    ///
    /// # Errors
    /// Error of the operating system.
    pub fn install() -> io::Result<Self> {
        let signals = Self::default();
        for signal in [SIGTERM, SIGINT] {
            // Registered first, so that the first signal finds the flag unset.
            fatal_signals::report_second(signal, Arc::clone(&signals.stop))?;
            flag::register_conditional_shutdown(signal, 128 + signal, Arc::clone(&signals.stop))?;
            flag::register(signal, Arc::clone(&signals.stop))?;
        }
        flag::register(SIGHUP, Arc::clone(&signals.reload))?;
        Ok(signals)
    }

    pub(super) fn stop_requested(&self) -> bool {
        self.stop.load(Ordering::Relaxed)
    }

    pub(super) fn take_reload_request(&self) -> bool {
        self.reload.swap(false, Ordering::Relaxed)
    }
}

/// Connection to the service manager, if any.
#[derive(Debug)]
pub(super) struct ServiceManager {
    watchdog: Option<Duration>,
    watchdog_at: Instant,
    watchdog_ticks: u64,
}

impl ServiceManager {
    pub(super) fn from_environment() -> Self {
        // A third of the period tolerates one late round.
        let watchdog = sd_notify::watchdog_enabled().map(|period| period / 3);
        Self {
            watchdog,
            watchdog_at: Instant::now(),
            watchdog_ticks: 0,
        }
    }

    /// Reports READY after the first tick, and feeds the watchdog while ticks advance.
    pub(super) fn report_ticks(&mut self, ticks: u64) {
        if ticks == self.watchdog_ticks {
            return;
        }
        if self.watchdog_ticks == 0 {
            self.ready();
        } else if self
            .watchdog
            .is_none_or(|period| self.watchdog_at.elapsed() < period)
        {
            return;
        } else {
            notify(&[NotifyState::Watchdog]);
        }
        (self.watchdog_at, self.watchdog_ticks) = (Instant::now(), ticks);
    }

    pub(super) fn ready(&self) {
        notify(&[NotifyState::Ready]);
    }

    pub(super) fn reloading(&self) {
        match NotifyState::monotonic_usec_now() {
            Ok(time) => notify(&[NotifyState::Reloading, time]),
            Err(error) => tracing::warn!(%error, "could not report the reload to the service \
                manager"),
        }
    }

    pub(super) fn stopping(&self) {
        notify(&[NotifyState::Stopping]);
    }
}

/// Does nothing without a service manager.
fn notify(states: &[NotifyState<'_>]) {
    if let Err(error) = sd_notify::notify(states) {
        tracing::warn!(%error, "could not notify the service manager");
    }
}
