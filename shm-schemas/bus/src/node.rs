//! iceoryx2 node: service variant, settings, node counter.

use std::fs::{File, Permissions};
use std::io::{self, Write};
use std::os::unix::fs::{OpenOptionsExt, PermissionsExt};
use std::path::PathBuf;
use std::time::Duration;

use iceoryx2::prelude::{Config, Node, NodeBuilder, NodeName, SignalHandlingMode, ipc};
use iceoryx2_bb_elementary::package_version::PackageVersion;

use crate::error::BusError;
use crate::folder::SHM;
use crate::location::Location;

/// iceoryx2's variant for shared memory between processes, without a mutex around every port.
pub(crate) type Ipc = ipc::Service;

/// Real-time property of a thread.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Realtime {
    /// Real-time: sending and receiving never wait for a peer during set-up and never log.
    Yes,
    /// Not real-time.
    No,
}

/// Time limit for non-real-time nodes to wait for a peer's set-up. Design choice.
const PEER_WAIT: Duration = Duration::from_millis(100);

/// iceoryx2's settings for a thread.
pub(crate) fn config(place: &Location, realtime: Realtime) -> Result<Config, BusError> {
    let mut config = place.config()?;
    config.global.creation_timeout = if realtime == Realtime::Yes {
        Duration::ZERO
    } else {
        PEER_WAIT
    };
    // A clean-up takes up to 21 ms per dead node and must survive a kill, so only `clean` does it.
    config.global.service.cleanup_dead_nodes_on_open = false;
    config.global.node.cleanup_dead_nodes_on_creation = false;
    config.global.node.cleanup_dead_nodes_on_destruction = false;
    Ok(config)
}

/// Creates a node. Call under the start-up lock only.
pub(crate) fn create(place: &Location, config: &Config, role: &str) -> Result<Node<Ipc>, String> {
    make_counter(place).map_err(|e| format!("the node counter: {e}"))?;
    let name = NodeName::new(role).map_err(|e| format!("the role {role:?}: {e:?}"))?;
    let builder = NodeBuilder::new()
        .name(&name)
        .config(config)
        .signal_handling_mode(SignalHandlingMode::Disabled);
    builder.create::<Ipc>().map_err(|e| format!("{e:?}"))
}

/// Creates iceoryx2's node counter if there is none.
///
/// iceoryx2 0.10 would create it with `fchmod(0666)`, whatever the umask: any user could briefly
/// open it for writing and truncate it (SIGBUS). It uses an existing one. The test
/// `counter_equals_the_one_of_iceoryx2` compares both.
fn make_counter(place: &Location) -> io::Result<()> {
    let path = counter_path(place);
    let mut options = File::options();
    // Unreadable until complete, as in iceoryx2, so that an unfinished one is recognised.
    options.write(true).create_new(true).mode(0o200);
    let mut file = match options.open(&path) {
        Err(e) if e.kind() == io::ErrorKind::AlreadyExists => return Ok(()),
        opened => opened?,
    };
    file.write_all(&counter_bytes())?;
    file.set_permissions(Permissions::from_mode(0o600))
}

/// SHA-1 of `iceoryx2::node::global_management_segment::State`, the counter's type, as part of the
/// file name.
const COUNTER_TYPE_HASH: &str = "9204dd183d1c4d8e1ff592a30766ffa6765aa8b5";

fn counter_path(place: &Location) -> PathBuf {
    let (version, prefix) = (PackageVersion::get(), &place.prefix);
    let (major, minor, patch) = (version.major(), version.minor(), version.patch());
    PathBuf::from(format!(
        "{SHM}/{prefix}{COUNTER_TYPE_HASH}_node.{major}_{minor}_{patch}.global_mgmt"
    ))
}

/// Version of iceoryx2, a count of zero, padding.
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
    fn counter_equals_the_one_of_iceoryx2() {
        let folder = Folder::for_bus(&BusName::fresh("counter")).expect("a folder");
        folder.make().expect("made");
        let place = Location::create(&folder).expect("a place");
        let node = NodeBuilder::new()
            .config(&config(&place, Realtime::No).expect("settings"))
            .signal_handling_mode(SignalHandlingMode::Disabled);
        let node = node.create::<Ipc>().expect("a node");
        let mut made = std::fs::read(counter_path(&place)).expect("iceoryx2 uses this file name");
        // iceoryx2 has counted its node.
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
