//! Requests that wait for their answers.

use std::collections::BTreeMap;

/// Longest list of waiting requests. Design choice: results of as many unfinished goals.
const WAITING_MAX: usize = 1024;

/// Origin of a request, valid until it is answered.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Caller(u64);

/// Returns the origin of a request in a test.
#[cfg(test)]
pub(crate) fn test_caller() -> Caller {
    Caller(0)
}

/// Origins of unanswered requests. The oldest one is dropped on overflow.
#[derive(Debug)]
pub(super) struct Waiting<T> {
    next: u64,
    origins: BTreeMap<Caller, T>,
}

impl<T> Default for Waiting<T> {
    fn default() -> Self {
        Self {
            next: 0,
            origins: BTreeMap::new(),
        }
    }
}

impl<T> Waiting<T> {
    pub(super) fn add(&mut self, origin: T) -> Caller {
        if self.origins.len() >= WAITING_MAX {
            self.origins.pop_first();
        }
        let caller = Caller(self.next);
        self.next += 1;
        self.origins.insert(caller, origin);
        caller
    }

    pub(super) fn remove(&mut self, caller: Caller) -> anyhow::Result<T> {
        let origin = self.origins.remove(&caller);
        origin.ok_or_else(|| {
            anyhow::anyhow!(
                "could not answer a request: more than {WAITING_MAX} requests wait for an answer"
            )
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn oldest_request_is_dropped_on_overflow() {
        let mut waiting = Waiting::default();
        let first = waiting.add(0);
        let later: Vec<Caller> = (1..=WAITING_MAX).map(|n| waiting.add(n)).collect();
        assert!(waiting.remove(first).is_err());
        assert_eq!(waiting.remove(later[0]).expect("waits"), 1);
        assert!(waiting.remove(later[0]).is_err(), "answered once");
    }
}
