//! Handles of this process per bus.
//!
//! A process with a handle is alive, so it need not list all nodes to find a process on the bus: a
//! list examines every node, and the time for N handles would grow with N².

use std::collections::BTreeMap;
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Number of handles by the prefix of the bus and the process, because a forked child inherits the
/// map but not the handles.
type Handles = BTreeMap<(String, u32), usize>;

static HANDLES: Mutex<Handles> = Mutex::new(BTreeMap::new());

fn handles() -> MutexGuard<'static, Handles> {
    HANDLES.lock().unwrap_or_else(PoisonError::into_inner)
}

fn key(prefix: &str) -> (String, u32) {
    (prefix.to_owned(), std::process::id())
}

/// Counts a new handle. Call after its node exists.
pub(crate) fn enter(prefix: &str) {
    *handles().entry(key(prefix)).or_default() += 1;
}

/// Ends the count of a handle; returns true if this process has another one. Call after its node
/// is gone.
pub(crate) fn leave(prefix: &str) -> bool {
    let (mut handles, key) = (handles(), key(prefix));
    let left = handles.get(&key).map_or(0, |count| count - 1);
    match left {
        0 => drop(handles.remove(&key)),
        left => drop(handles.insert(key, left)),
    }
    left > 0
}

/// Returns true if this process has a handle.
pub(crate) fn is_present(prefix: &str) -> bool {
    handles().contains_key(&key(prefix))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn last_handle_ends_the_presence() {
        let (one, other) = ("presence-test-1", "presence-test-2");
        assert!(!is_present(one) && !leave(one));
        enter(one);
        enter(one);
        enter(other);
        assert!(leave(one) && is_present(one));
        assert!(!leave(one) && !is_present(one));
        assert!(is_present(other) && !leave(other));
    }
}
