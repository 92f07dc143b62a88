//! Message of a panic on the tick thread, without the 65 ms for printing a backtrace there.

use parking_lot::Mutex;

pub(crate) const TICK_THREAD: &str = "atasd-tick";

static MESSAGE: Mutex<Option<String>> = Mutex::new(None);

/// Installs a hook that stores panic messages of the tick thread; other threads print as before.
pub(crate) fn install_hook() {
    let print = std::panic::take_hook();
    std::panic::set_hook(Box::new(move |info| {
        if std::thread::current().name() != Some(TICK_THREAD) {
            return print(info);
        }
        // The tick must not wait: a lost message is acceptable.
        if let Some(mut note) = MESSAGE.try_lock() {
            *note = Some(info.to_string());
        }
    }));
}

#[must_use]
pub(crate) fn take_message() -> Option<String> {
    MESSAGE.lock().take()
}
