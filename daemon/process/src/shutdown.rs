//! Orderly shutdown: SIGINT or SIGTERM sets a flag that the main loop polls.

use std::io;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use signal_hook::consts::{SIGINT, SIGTERM};
use signal_hook::flag;

/// Signals that request an orderly shutdown.
pub const SIGNALS: [i32; 2] = [SIGINT, SIGTERM];
/// Exit code after a second signal (shell convention for Ctrl-C).
pub const IMMEDIATE_EXIT: i32 = 130;

/// Returns a flag that the first of the signals sets instead of ending the process. A second signal
/// ends the process immediately with the exit code `immediate_exit`.
///
/// # Errors
/// [`io::Error`] if the kernel does not install the handler.
pub fn install_stop_flag(signals: &[i32], immediate_exit: i32) -> io::Result<Arc<AtomicBool>> {
    let stop = Arc::new(AtomicBool::new(false));
    for &signal in signals {
        flag::register_conditional_shutdown(signal, immediate_exit, Arc::clone(&stop))?;
        flag::register(signal, Arc::clone(&stop))?;
    }
    Ok(stop)
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::Ordering;

    #[test]
    fn signal_sets_flag_without_ending_process() {
        let stop = super::install_stop_flag(&super::SIGNALS, super::IMMEDIATE_EXIT)
            .expect("signal handlers are installed");
        assert!(!stop.load(Ordering::Relaxed));
        rustix::process::kill_process(rustix::process::getpid(), rustix::process::Signal::TERM)
            .expect("the process can signal itself");
        while !stop.load(Ordering::Relaxed) {
            std::thread::yield_now();
        }
    }
}
