//! Exchange of tables with a real-time loop that must not block.

#[cfg(loom)]
use loom::sync::{
    Mutex,
    atomic::{AtomicBool, Ordering},
};
use std::sync::PoisonError;
#[cfg(not(loom))]
use std::sync::{
    Mutex,
    atomic::{AtomicBool, Ordering},
};

use super::Lookup;

/// One slot: holds the next tables until the loop takes them, then the previous ones until they are
/// freed by the next offer. `tests/loom` checks all interleavings of offer and take.
#[derive(Debug)]
pub struct Exchange {
    offered: AtomicBool,
    slot: Mutex<Option<Lookup>>,
}

impl Default for Exchange {
    fn default() -> Self {
        Self {
            offered: AtomicBool::new(false),
            slot: Mutex::new(None),
        }
    }
}

impl Exchange {
    /// Offers tables. The content of the slot, taken or not, is freed here and not in the loop.
    pub fn offer(&self, lookup: Lookup) {
        let mut place = self.slot.lock().unwrap_or_else(PoisonError::into_inner);
        *place = Some(lookup);
        self.offered.store(true, Ordering::Release);
    }

    /// Swaps offered tables into `current`; returns whether there was an offer. Does not block,
    /// allocate or free: an offer in progress counts as none.
    pub fn take(&self, current: &mut Lookup) -> bool {
        if !self.offered.load(Ordering::Acquire) {
            return false;
        }
        let Ok(mut place) = self.slot.try_lock() else {
            return false;
        };
        if let Some(next) = place.as_mut() {
            std::mem::swap(next, current);
        }
        self.offered.swap(false, Ordering::Relaxed)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::built_in;

    #[test]
    fn offer_is_taken_once() {
        let file = built_in::table("r3-two-agents").expect("built in");
        let mut current = Lookup::new(std::slice::from_ref(&file));
        let former = current.hash();
        let exchange = Exchange::default();
        assert!(!exchange.take(&mut current), "nothing on offer");
        let next = Lookup::new(&[file.clone(), file]);
        let hash = next.hash();
        assert_ne!(hash, former);
        exchange.offer(next);
        assert!(exchange.take(&mut current));
        assert_eq!((current.hash(), current.tables()), (hash, 2));
        assert!(!exchange.take(&mut current), "taken already");
        assert_eq!(current.hash(), hash);
    }
}
