//! Stop signal: listener, tick and supervisor in all interleavings.
#![cfg(loom)]

use atas_loom::signal::Signal;
use loom::sync::Arc;
use loom::sync::atomic::{AtomicU64, Ordering::Relaxed};
use loom::thread;

/// The signal, and the data that it publishes: last stop in the command, and in the status.
#[derive(Default)]
struct Daemon {
    signal: Signal,
    command: AtomicU64,
    status: AtomicU64,
}

impl Daemon {
    /// One tick: publishes the command, then confirms the stop. Returns whether there was one.
    fn tick(&self) -> bool {
        let stop = self.signal.pending();
        if let Some(number) = stop {
            self.command.store(number, Relaxed);
            self.signal.take(number);
        }
        stop.is_some()
    }

    /// One round of the supervisor: publishes the status, then confirms that it shows a stop.
    /// Returns whether there was one.
    fn publish_status(&self) -> bool {
        let stop = self.signal.unshown();
        self.status.store(self.command.load(Relaxed), Relaxed);
        if let Some(number) = stop {
            self.signal.show(number);
        }
        stop.is_some()
    }
}

/// Starts a thread that repeats a round until it had a stop.
fn start(daemon: &Arc<Daemon>, round: fn(&Daemon) -> bool) -> thread::JoinHandle<()> {
    let daemon = Arc::clone(daemon);
    thread::spawn(move || wait_for(|| round(&daemon)))
}

fn wait_for(condition: impl Fn() -> bool) {
    while !condition() {
        thread::yield_now();
    }
}

#[test]
fn no_stop_is_lost() {
    loom::model(|| {
        let daemon = Arc::new(Daemon::default());
        let tick = start(&daemon, Daemon::tick);
        let first = daemon.signal.raise();
        let second = daemon.signal.raise();
        assert_eq!((first, second), (1, 2));
        tick.join().unwrap();
        daemon.tick();
        assert_eq!(daemon.signal.pending(), None);
        assert!(daemon.signal.is_taken(first) && daemon.signal.is_taken(second));
        assert_eq!(daemon.command.load(Relaxed), second);
    });
}

#[test]
fn answer_follows_the_published_command() {
    loom::model(|| {
        let daemon = Arc::new(Daemon::default());
        let ticking = Arc::clone(&daemon);
        let tick = thread::spawn(move || (ticking.tick(), ticking.tick()));
        for _ in 0..2 {
            let number = daemon.signal.raise();
            if daemon.signal.is_taken(number) {
                assert!(daemon.command.load(Relaxed) >= number);
            }
        }
        tick.join().unwrap();
    });
}

/// A client that reads the status after the answer sees the stop.
#[test]
fn answer_follows_the_status_that_shows_the_stop() {
    loom::model(|| {
        let daemon = Arc::new(Daemon::default());
        let tick = start(&daemon, Daemon::tick);
        let supervisor = start(&daemon, Daemon::publish_status);
        let number = daemon.signal.raise();
        wait_for(|| daemon.signal.is_shown(number));
        assert!(daemon.signal.is_taken(number));
        assert_eq!(daemon.status.load(Relaxed), number);
        tick.join().unwrap();
        supervisor.join().unwrap();
    });
}
