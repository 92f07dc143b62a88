//! Clean-up after dead processes, safe against being killed at any moment.
//!
//! iceoryx2 0.10 removes a dead port in two steps: its tag (a file), then its slot at the service.
//! If the cleaner is killed in between, the next cleaner finds no tag and skips the port. The slot
//! stays lost while any process has the service open; a stream with one publisher slot is then
//! unusable. Therefore the tags are backed up first, and a cleaner that finds a backup restores it.
//! iceoryx2's automatic clean-ups are off ([`crate::node::config`]).

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use iceoryx2::node::NodeView;
use iceoryx2::prelude::{CallbackProgression, Node, NodeState};

use crate::folder::entries;
use crate::leftovers;
use crate::location::Location;
use crate::node::Ipc;

/// Folder of the tag backups, below the bus's folder.
const BACKUP_FOLDER: &str = "cleaning";
/// Suffix of a port's tag in iceoryx2.
const TAG: &str = ".port_tag";

/// Time to wait for another cleaner of the same node, such as a peer in another language. Five
/// times the longest removal.
const OTHER_CLEANER_WAIT: Duration = Duration::from_millis(100);

/// Time after a search in which further handles of this process on the same bus do not search. Each
/// search examines all nodes (0.1 ms or more per node), so a search per handle makes the time for N
/// handles grow with N². Design choice: a peer killed within this time keeps its slots until a
/// service lacks one, until [`crate::Bus::clean_dead`] or until a later handle.
const SEARCH_INTERVAL: Duration = Duration::from_secs(1);

/// Times of this process's last searches, by the prefix of the bus.
static SEARCHES: Mutex<Searches> = Mutex::new(Searches(BTreeMap::new()));

/// Last search per bus.
#[derive(Debug, Default)]
struct Searches(BTreeMap<String, Instant>);

impl Searches {
    /// Returns true, and starts a new interval, unless this bus was searched within the interval.
    fn begin(&mut self, prefix: &str, now: Instant) -> bool {
        self.0
            .retain(|_, at| now.duration_since(*at) < SEARCH_INTERVAL);
        if self.0.contains_key(prefix) {
            return false;
        }
        self.0.insert(prefix.to_owned(), now);
        true
    }
}

/// Removes dead nodes for a new handle, unless this process did it on this bus less than
/// [`SEARCH_INTERVAL`] ago. The first handle of a process always does: a restarted daemon removes
/// the remains of a killed one. Call under the start-up lock only.
pub(crate) fn remove_dead_for_new_handle(place: &Location, node: &Node<Ipc>) {
    let is_due = {
        let mut searches = SEARCHES.lock().unwrap_or_else(PoisonError::into_inner);
        searches.begin(&place.prefix, Instant::now())
    };
    if is_due {
        remove_dead(place, node);
    }
}

/// Removes dead nodes and returns their number. Call under the start-up lock only.
pub(crate) fn remove_dead(place: &Location, node: &Node<Ipc>) -> usize {
    let (nodes, notes) = (place.root().join("nodes"), place.root().join(BACKUP_FOLDER));
    let dead = dead_nodes(node);
    if dead.is_empty() {
        return 0;
    }
    for DeadNode {
        id,
        has_description: described,
    } in &dead
    {
        let folder = nodes.join(id);
        if *described {
            restore_tags(&notes, &folder);
            back_up_tags(&notes, &folder);
        } else {
            remove_node_files(&nodes, id);
        }
    }
    let state = node.blocking_cleanup_dead_nodes(OTHER_CLEANER_WAIT);
    if state.failed_cleanups == 0 {
        // Leftovers are removed by the next clean-up; backups of removed nodes are harmless.
        let _ = fs::remove_dir_all(&notes);
    }
    dead.len().saturating_sub(state.failed_cleanups as usize)
}

struct DeadNode {
    id: String,
    /// True if its description exists. Removing it is a cleaner's last but one step.
    has_description: bool,
}

fn dead_nodes(node: &Node<Ipc>) -> Vec<DeadNode> {
    let mut dead = Vec::new();
    // A list that breaks off is continued by the next clean-up.
    let _ = Node::<Ipc>::list(node.config(), |state| {
        if let NodeState::Dead(view) = state {
            dead.push(DeadNode {
                id: view.id().value().to_string(),
                has_description: view.details().is_some(),
            });
        }
        CallbackProgression::Continue
    });
    dead
}

/// Does the last step of a killed cleaner. iceoryx2 would search for the node on its default bus.
fn remove_node_files(nodes: &Path, id: &str) {
    let (folder, file) = (id, format!("_{id}."));
    let of_node = |path: &PathBuf| {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        name == folder || name.contains(&file)
    };
    for (path, _) in entries(nodes).filter(|(path, _)| of_node(path)) {
        leftovers::remove(&path);
    }
}

/// A backup consists of hard links to the tags, in a folder named like the node's.
fn back_up_tags(notes: &Path, node: &Path) {
    let Some(backup_path) = backup_path(notes, node) else {
        return;
    };
    if let Err(error) = fs::create_dir_all(&backup_path) {
        tracing::warn!(folder = %backup_path.display(), %error, "could not back up the port tags before \
            the clean-up");
    }
    link_tags(node, &backup_path);
}

fn restore_tags(notes: &Path, node: &Path) {
    if let Some(backup_path) = backup_path(notes, node) {
        link_tags(&backup_path, node);
    }
}

fn backup_path(notes: &Path, node: &Path) -> Option<PathBuf> {
    node.file_name().map(|name| notes.join(name))
}

/// Keeps existing tags; does nothing if the folder is gone.
fn link_tags(from: &Path, to: &Path) {
    let tags = entries(from)
        .map(|(path, _)| path)
        .filter(|path| path.to_string_lossy().ends_with(TAG));
    for tag in tags {
        if let Some(name) = tag.file_name() {
            let _ = fs::hard_link(&tag, to.join(name));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_bus_is_searched_once_per_interval() {
        let (mut searches, begin) = (Searches::default(), Instant::now());
        let mut check = |prefix: &str, after: Duration, expected: bool| {
            let is_due = searches.begin(prefix, begin + after);
            assert_eq!(is_due, expected, "{prefix} after {after:?}");
        };
        let soon = SEARCH_INTERVAL / 2;
        check("one", Duration::ZERO, true);
        check("one", Duration::ZERO, false);
        check("two", soon, true);
        check("one", soon, false);
        check("one", SEARCH_INTERVAL, true);
        check("two", SEARCH_INTERVAL, false);
        check("one", SEARCH_INTERVAL + soon, false);
        check("two", SEARCH_INTERVAL + soon, true);
    }

    #[test]
    fn past_searches_are_forgotten() {
        let (mut searches, begin) = (Searches::default(), Instant::now());
        for bus in 0..10_u32 {
            searches.begin(&bus.to_string(), begin + bus * SEARCH_INTERVAL);
        }
        assert_eq!(searches.0.len(), 1);
    }
}
