//! What a panic on the tick thread said, without the 65 ms that printing a backtrace takes there.

use parking_lot::Mutex;

/// Name of the tick thread.
pub(crate) const TICK_THREAD: &str = "atasd-tick";

static NOTE: Mutex<Option<String>> = Mutex::new(None);

/// From now on a panic of the tick thread is noted instead of printed; other threads panic as before.
pub(crate) fn note_those_of_the_tick() {
    let print = std::panic::take_hook();
    std::panic::set_hook(Box::new(move |info| {
        if std::thread::current().name() != Some(TICK_THREAD) {
            return print(info);
        }
        // Nobody holds the lock for long, and a note that is lost costs less than a tick that waits.
        if let Some(mut note) = NOTE.try_lock() {
            *note = Some(info.to_string());
        }
    }));
}

/// What the last panic of the tick thread said, once.
#[must_use]
pub(crate) fn take_note() -> Option<String> {
    NOTE.lock().take()
}
