//! Orderly shutdown: SIGINT or SIGTERM sets a flag that the main loop polls.

use std::io;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use signal_hook::consts::{SIGINT, SIGTERM};
use signal_hook::flag;

/// Signals that request an orderly shutdown.
pub const SIGNALS: [i32; 2] = [SIGINT, SIGTERM];
/// Exit code after a second signal (shell convention for Ctrl-C).
pub const AT_ONCE: i32 = 130;

/// Returns a flag that the first of the signals sets instead of ending the process. A second signal
/// ends the process immediately with the exit code `immediate_exit`.
///
/// # Errors
/// [`io::Error`] if the kernel does not install the handler.
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
