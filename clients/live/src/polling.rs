//! Polling loop at 60 Hz that survives the end of a daemon.

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use atas_client::{ClientError, Observer, Session};
use shm_bus::BusName;

const POLL_INTERVAL: Duration = Duration::from_nanos(16_666_667);
/// Pause before a missing bus is tried again.
const RETRY_INTERVAL: Duration = Duration::from_millis(300);

/// Polls the bus until `stop` is set. `begin` makes an observer of a bus, `look` polls it. An error
/// ends the observer, is passed to `gone`, and the loop continues.
pub(crate) fn poll_bus<T, E: From<ClientError>>(
    bus: &BusName,
    stop: &AtomicBool,
    mut begin: impl FnMut(Observer, &Session) -> Result<T, E>,
    mut look: impl FnMut(&mut T, &Session) -> Result<(), E>,
    mut gone: impl FnMut(&E),
) {
    let mut observe = || {
        let session = Session::existing(bus)?;
        let watch = Observer::join(&session).map_err(ClientError::from)?;
        let mut observer = begin(watch, &session)?;
        let mut due = Instant::now();
        while !stop.load(Ordering::Relaxed) {
            look(&mut observer, &session)?;
            due = (due + POLL_INTERVAL).max(Instant::now());
            std::thread::sleep(due.saturating_duration_since(Instant::now()));
        }
        Ok(())
    };
    while !stop.load(Ordering::Relaxed) {
        if let Err(error) = observe() {
            gone(&error);
            std::thread::sleep(RETRY_INTERVAL);
        }
    }
}
