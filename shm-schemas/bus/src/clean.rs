//! Cleaning up after dead processes, such that it may itself be killed at any moment.
//!
//! iceoryx2 0.10 removes a dead port in two steps: its tag (a file), then its place at the service. If the cleaner is
//! killed between the two, the next cleaner misses the tag, skips the port, and the place is lost as long as anyone
//! has the service open: with one place for a publisher, the stream is dead. So the tags are noted down before, and a
//! cleaner that finds the notes of a killed one first puts the tags back. iceoryx2's own occasions for cleaning up are
//! switched off ([`crate::node::config`]); everything goes through [`remove_dead`], under the start-up lock.

use std::fs;
use std::path::{Path, PathBuf};
use std::time::Duration;

use iceoryx2::node::NodeView;
use iceoryx2::prelude::{CallbackProgression, Node, NodeState};

use crate::folder::entries;
use crate::node::Ipc;
use crate::place::Place;
use crate::remains;

/// Folder of the notes, below the bus's folder.
const NOTES: &str = "cleaning";
/// How iceoryx2 names a port's tag.
const TAG: &str = ".port_tag";

/// How long to wait for another cleaner of the same node: a peer in another language, or another bus's in this
/// process. Five times what removing a node takes at most.
const OTHER_CLEANER: Duration = Duration::from_millis(100);

/// Removes what dead nodes left; returns how many nodes. Call under the start-up lock only.
pub(crate) fn remove_dead(place: &Place, node: &Node<Ipc>) -> usize {
    let (nodes, notes) = (place.root().join("nodes"), place.root().join(NOTES));
    let dead = dead_nodes(node);
    if dead.is_empty() {
        return 0;
    }
    for Dead { id, described } in &dead {
        let folder = nodes.join(id);
        if *described {
            put_back(&notes, &folder);
            note_down(&notes, &folder);
        } else {
            remove_remains(&nodes, id);
        }
    }
    let state = node.blocking_cleanup_dead_nodes(OTHER_CLEANER);
    if state.failed_cleanups == 0 {
        // What cannot be removed now is removed next time; notes about nodes that are gone do no harm.
        let _ = fs::remove_dir_all(&notes);
    }
    dead.len().saturating_sub(state.failed_cleanups as usize)
}

struct Dead {
    id: String,
    /// Whether its description is there. Removing it is the last but one step of a cleaner.
    described: bool,
}

fn dead_nodes(node: &Node<Ipc>) -> Vec<Dead> {
    let mut dead = Vec::new();
    // A list that breaks off is continued next time.
    let _ = Node::<Ipc>::list(node.config(), |state| {
        if let NodeState::Dead(view) = state {
            dead.push(Dead {
                id: view.id().value().to_string(),
                described: view.details().is_some(),
            });
        }
        CallbackProgression::Continue
    });
    dead
}

/// The last step of a cleaner that was killed before it; iceoryx2 would look for the node on its default bus.
fn remove_remains(nodes: &Path, id: &str) {
    let (folder, file) = (id, format!("_{id}."));
    let of_node = |path: &PathBuf| {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        name == folder || name.contains(&file)
    };
    for (path, _) in entries(nodes).filter(|(path, _)| of_node(path)) {
        remains::remove(&path);
    }
}

/// Notes are second names (hard links) of the tags, in a folder named like the node's.
fn note_down(notes: &Path, node: &Path) {
    let Some(noted) = noted(notes, node) else {
        return;
    };
    if let Err(error) = fs::create_dir_all(&noted) {
        tracing::warn!(folder = %noted.display(), %error, "could not note down what is being removed");
    }
    link_tags(node, &noted);
}

fn put_back(notes: &Path, node: &Path) {
    if let Some(noted) = noted(notes, node) {
        link_tags(&noted, node);
    }
}

fn noted(notes: &Path, node: &Path) -> Option<PathBuf> {
    node.file_name().map(|name| notes.join(name))
}

/// A tag that is there already stays; a folder that is gone needs none.
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
