//! Hand-over of a stop from the listener to the tick.

#[cfg(loom)]
use loom::sync::atomic::{AtomicU64, Ordering};
#[cfg(not(loom))]
use std::sync::atomic::{AtomicU64, Ordering};

/// Number of received stops, and numbers of the last one that a tick took and that the published
/// status shows.
///
/// All sides are wait-free: one load or one store each. `tests/loom` checks all their interleavings.
#[derive(Debug, Default)]
pub struct Signal {
    received: AtomicU64,
    taken: AtomicU64,
    shown: AtomicU64,
}

impl Signal {
    /// For the tick: the number of a stop that no tick has taken yet. Poll it every tick; stop;
    /// then call [`Signal::take`].
    #[must_use]
    pub fn pending(&self) -> Option<u64> {
        let received = self.received.load(Ordering::Acquire);
        (received != self.taken.load(Ordering::Relaxed)).then_some(received)
    }

    /// For the tick: confirms that its commands now include the stop with this number and all
    /// earlier ones.
    pub fn take(&self, number: u64) {
        self.taken.store(number, Ordering::Release);
    }

    /// For the publisher of the status: the number of a taken stop that no status shows yet. Read
    /// it before the state; publish; then call [`Signal::show`].
    #[must_use]
    pub fn unshown(&self) -> Option<u64> {
        let taken = self.taken.load(Ordering::Acquire);
        (taken != self.shown.load(Ordering::Relaxed)).then_some(taken)
    }

    /// For the publisher of the status: confirms that readers see the stop with this number.
    pub fn show(&self, number: u64) {
        self.shown.store(number, Ordering::Release);
    }

    /// Returns true once a published status shows the stop with this number.
    #[must_use]
    pub fn is_shown(&self, number: u64) -> bool {
        self.shown.load(Ordering::Acquire) >= number
    }

    /// For the listener: records a received stop. Returns its number, from 1.
    pub fn raise(&self) -> u64 {
        self.received.fetch_add(1, Ordering::AcqRel) + 1
    }

    /// Returns true once a tick took the stop with this number.
    #[must_use]
    pub fn is_taken(&self, number: u64) -> bool {
        self.taken.load(Ordering::Acquire) >= number
    }
}

#[cfg(test)]
mod tests {
    use super::Signal;

    #[test]
    fn stop_is_pending_until_taken() {
        let signal = Signal::default();
        assert_eq!(signal.pending(), None);
        let first = signal.raise();
        assert_eq!(
            (signal.pending(), signal.is_taken(first)),
            (Some(first), false)
        );
        let second = signal.raise();
        assert_eq!(
            signal.pending(),
            Some(second),
            "newest stop covers the older ones"
        );
        signal.take(first);
        assert_eq!(
            signal.pending(),
            Some(second),
            "stop that arrives meanwhile is kept"
        );
        signal.take(second);
        assert_eq!((signal.pending(), signal.is_taken(first)), (None, true));
        assert_eq!(
            (signal.unshown(), signal.is_shown(first)),
            (Some(second), false)
        );
        signal.show(second);
        assert_eq!((signal.unshown(), signal.is_shown(first)), (None, true));
    }
}
