//! The end of a process in order: SIGINT or SIGTERM as a flag that its loop looks at.

use std::io;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use signal_hook::consts::{SIGINT, SIGTERM};
use signal_hook::flag;

/// The signals that end a process in order.
pub const SIGNALS: [i32; 2] = [SIGINT, SIGTERM];
/// Exit code of a process that a second signal ends, by the shells' convention for Ctrl-C.
pub const AT_ONCE: i32 = 130;

/// A flag that the first of the signals sets, instead of ending the process. A second one ends it at once, with the exit
/// code `at_once`.
///
/// # Errors
/// [`io::Error`] if the kernel refuses to tell of a signal.
pub fn on_signals(signals: &[i32], at_once: i32) -> io::Result<Arc<AtomicBool>> {
    let stop = Arc::new(AtomicBool::new(false));
    for &signal in signals {
        flag::register_conditional_shutdown(signal, at_once, Arc::clone(&stop))?;
        flag::register(signal, Arc::clone(&stop))?;
    }
    Ok(stop)
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::Ordering;

    #[test]
    fn a_signal_sets_the_flag_and_the_process_lives() {
        let stop =
            super::on_signals(&super::SIGNALS, super::AT_ONCE).expect("signals can be watched");
        assert!(!stop.load(Ordering::Relaxed));
        rustix::process::kill_process(rustix::process::getpid(), rustix::process::Signal::TERM)
            .expect("a process may signal itself");
        while !stop.load(Ordering::Relaxed) {
            std::thread::yield_now();
        }
    }
}
