//! iceoryx2's node: its variant, its settings, its counter.

use std::fs::{File, Permissions};
use std::io::{self, Write};
use std::os::unix::fs::{OpenOptionsExt, PermissionsExt};
use std::path::PathBuf;
use std::time::Duration;

use iceoryx2::prelude::{Config, Node, NodeBuilder, NodeName, SignalHandlingMode, ipc};
use iceoryx2_bb_elementary::package_version::PackageVersion;

use crate::error::BusError;
use crate::folder::SHM;
use crate::place::Place;

/// iceoryx2's variant: shared memory between processes, without a mutex around every port.
pub(crate) type Ipc = ipc::Service;

/// Whether a thread has a deadline.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Realtime {
    /// It has: sending and receiving never wait for a peer that is being set up, and never log.
    Yes,
    /// It has not.
    No,
}

/// How long non-real-time nodes wait for a peer that is being set up. Real-time nodes do not wait. Ours.
const PEER_WAIT: Duration = Duration::from_millis(100);

/// iceoryx2's settings for a thread.
pub(crate) fn config(place: &Place, realtime: Realtime) -> Result<Config, BusError> {
    let mut config = place.config()?;
    config.global.creation_timeout = if realtime == Realtime::Yes {
        Duration::ZERO
    } else {
        PEER_WAIT
    };
    // Cleaning up costs up to 21 ms per dead node and must survive being killed: only `clean` does it.
    config.global.service.cleanup_dead_nodes_on_open = false;
    config.global.node.cleanup_dead_nodes_on_creation = false;
    config.global.node.cleanup_dead_nodes_on_destruction = false;
    Ok(config)
}

/// Makes a node. Call under the start-up lock only.
pub(crate) fn create(place: &Place, config: &Config, role: &str) -> Result<Node<Ipc>, String> {
    make_counter(place).map_err(|e| format!("the node counter: {e}"))?;
    let name = NodeName::new(role).map_err(|e| format!("the role {role:?}: {e:?}"))?;
    let builder = NodeBuilder::new()
        .name(&name)
        .config(config)
        .signal_handling_mode(SignalHandlingMode::Disabled);
    builder.create::<Ipc>().map_err(|e| format!("{e:?}"))
}

/// Makes the counter that iceoryx2 numbers its nodes with, if there is none.
///
/// iceoryx2 0.10 would make it with `fchmod(0666)`, whatever the umask: for a moment every user could open it writable
/// and truncate it under us (SIGBUS). It uses one that it finds. `the_counter_is_what_iceoryx2_would_make` compares.
fn make_counter(place: &Place) -> io::Result<()> {
    let path = counter(place);
    let mut options = File::options();
    // As iceoryx2 does it: unreadable until it is finished, so that a half-made one is recognised.
    options.write(true).create_new(true).mode(0o200);
    let mut file = match options.open(&path) {
        Err(e) if e.kind() == io::ErrorKind::AlreadyExists => return Ok(()),
        opened => opened?,
    };
    file.write_all(&counter_bytes())?;
    file.set_permissions(Permissions::from_mode(0o600))
}

/// SHA-1 of `iceoryx2::node::global_management_segment::State`, the type of the counter, as iceoryx2 puts it in the name.
const COUNTER_TYPE: &str = "9204dd183d1c4d8e1ff592a30766ffa6765aa8b5";

fn counter(place: &Place) -> PathBuf {
    let (version, prefix) = (PackageVersion::get(), &place.prefix);
    let (major, minor, patch) = (version.major(), version.minor(), version.patch());
    PathBuf::from(format!(
        "{SHM}/{prefix}{COUNTER_TYPE}_node.{major}_{minor}_{patch}.global_mgmt"
    ))
}

/// The version of iceoryx2, a count of zero, padding.
fn counter_bytes() -> [u8; 16] {
    let mut bytes = [0; 16];
    bytes[..8].copy_from_slice(&PackageVersion::get().to_u64().to_ne_bytes());
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::folder::Folder;
    use crate::name::BusName;

    #[test]
    fn the_counter_is_what_iceoryx2_would_make() {
        let folder = Folder::of(&BusName::fresh("counter")).expect("a folder");
        folder.make().expect("made");
        let place = Place::draw(&folder).expect("a place");
        let node = NodeBuilder::new()
            .config(&config(&place, Realtime::No).expect("settings"))
            .signal_handling_mode(SignalHandlingMode::Disabled);
        let node = node.create::<Ipc>().expect("a node");
        let mut made = std::fs::read(counter(&place)).expect("iceoryx2 still names it so");
        // It has counted one node by now.
        assert_eq!(made[8], 1);
        made[8] = 0;
        assert_eq!(made, counter_bytes());
        drop(node);
        place
            .shared_memory()
            .for_each(|(path, _)| std::fs::remove_file(path).expect("removed"));
        std::fs::remove_dir_all(&folder.path).expect("removed");
    }
}
