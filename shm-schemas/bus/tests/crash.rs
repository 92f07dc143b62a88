//! Leftovers of killed processes do not disturb later processes (fault F51).

mod common;

use std::fs;
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};
use std::time::Duration;

use common::{Peer, peer_role, ready, until};
use shm_bus::{Bus, BusError, BusName, FreshBus, OwnerLock, Realtime};
use shm_schemas::service::{CONTROL, JOINT_COMMAND, STATUS};
use shm_schemas::{JointCommand, Status};

fn open(bus: &BusName, role: &str) -> Bus {
    Bus::open(bus, role, Realtime::No).expect("the bus opens")
}

/// Opens the bus as a daemon does at start-up.
fn start_daemon(name: &BusName) -> impl Sized + use<> {
    let owner = OwnerLock::take(name, "atasd").expect("sole owner");
    let bus = open(name, "atasd");
    let command = bus
        .publisher::<JointCommand>(JOINT_COMMAND)
        .expect("commands");
    let status = bus.publisher::<Status>(STATUS).expect("status");
    let (goals, control) = (
        bus.goal_server().expect("goals"),
        bus.control_server().expect("control"),
    );
    (owner, bus, command, status, goals, control)
}

#[test]
fn peer() {
    let Some((role, name)) = peer_role() else {
        return;
    };
    match role.as_str() {
        "daemon" => {
            let _daemon = start_daemon(&name);
            ready();
            std::thread::sleep(Duration::from_secs(60));
        }
        "holder" => {
            let _owner = OwnerLock::take(&name, "holder").expect("sole owner");
            ready();
            std::thread::sleep(Duration::from_secs(60));
        }
        "member" => {
            let _bus = open(&name, "member");
            ready();
            std::thread::sleep(Duration::from_secs(60));
        }
        other => panic!("no role {other}"),
    }
}

/// Kills daemons at many moments of their start-up; each time the next daemon must start and
/// `check` must pass.
fn kill_during_startup(name: &BusName, mut received: impl FnMut()) {
    for step in 0..24 {
        let daemon = Peer::spawn(name, "daemon");
        std::thread::sleep(Duration::from_micros(1500 + 250 * step));
        daemon.kill();
        let daemon = Peer::start(name, "daemon");
        received();
        daemon.kill();
    }
}

#[test]
fn start_up_survives_kills_on_an_empty_bus() {
    let name = FreshBus::new("empty");
    kill_during_startup(&name, || {});
}

#[test]
fn start_up_survives_kills_with_an_observer_attached() {
    let name = FreshBus::new("watched");
    let bus = open(&name, "observer");
    let mut commands = bus
        .subscriber::<JointCommand>(JOINT_COMMAND)
        .expect("subscriber");
    let client = bus.control_client().expect("client");
    kill_during_startup(&name, || {
        commands.drain(4, |_| {}).expect("read");
        // The server exists but does not answer.
        let unanswered = client
            .call(&Default::default(), Duration::ZERO)
            .expect_err("no answer");
        assert!(
            matches!(
                unanswered,
                BusError::NoAnswer {
                    service: CONTROL,
                    ..
                }
            ),
            "{unanswered}"
        );
    });
}

fn files(folder: &Path, ending: &str) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder)
        .into_iter()
        .flatten()
        .flatten()
        .map(|entry| entry.path());
    entries
        .filter(|path| path.to_string_lossy().ends_with(ending))
        .collect()
}

fn memory(name: &BusName, ending: &str) -> Vec<PathBuf> {
    let mut all = files(Path::new("/dev/shm"), ending);
    all.retain(|path| path.to_string_lossy().contains(&format!("/{name}_")));
    all
}

/// Damages a bus with an observer as a kill at the wrong moment would, and starts a daemon.
fn check_recovery(label: &str, spoil: impl FnOnce(&BusName, &Path)) {
    let name = FreshBus::new(label);
    let observer = open(&name, "observer");
    {
        // Creates the service to damage; the next daemon opens it again.
        let maker = Peer::start(&name, "daemon");
        spoil(&name, observer.folder());
        maker.kill();
    }
    let daemon = start_daemon(&name);
    let mut commands = observer
        .subscriber::<JointCommand>(JOINT_COMMAND)
        .expect("subscriber");
    drop((commands.drain(1, |_| {}).expect("read"), daemon));
}

#[test]
fn service_without_memory_is_recreated() {
    check_recovery("memory", |name, _| {
        let dynamic = memory(name, ".dynamic");
        assert!(!dynamic.is_empty(), "iceoryx2 uses these file names");
        dynamic
            .iter()
            .for_each(|path| fs::remove_file(path).expect("removed"));
    });
}

#[test]
fn empty_memory_is_recreated() {
    check_recovery("zero", |name, _| {
        for path in memory(name, ".dynamic") {
            fs::remove_file(&path).expect("removed");
            fs::write(&path, "").expect("an empty file");
        }
    });
}

#[test]
fn unfinished_memory_is_recreated() {
    check_recovery("memmode", |name, _| {
        for path in memory(name, ".dynamic") {
            fs::set_permissions(&path, fs::Permissions::from_mode(0o200)).expect("mode");
        }
    });
}

#[test]
fn unfinished_description_is_recreated() {
    check_recovery("descr", |_, folder| {
        let descriptions = files(&folder.join("services"), ".service");
        assert!(!descriptions.is_empty(), "iceoryx2 uses these file names");
        for path in descriptions {
            fs::set_permissions(&path, fs::Permissions::from_mode(0o200)).expect("mode");
        }
    });
}

#[test]
fn corrupt_description_is_recreated() {
    check_recovery("garbled", |_, folder| {
        for path in files(&folder.join("services"), ".service") {
            fs::set_permissions(&path, fs::Permissions::from_mode(0o600)).expect("mode");
            fs::write(&path, "garbled").expect("written");
        }
    });
}

/// Fails without the tag backup: the killed daemon's slots are then lost until the observer leaves.
#[test]
fn killed_cleaner_loses_no_slots() {
    let name = FreshBus::new("cleaner");
    let observer = open(&name, "observer");
    let _commands = observer
        .subscriber::<JointCommand>(JOINT_COMMAND)
        .expect("subscriber");
    let _client = observer.goal_client().expect("client");
    let nodes = observer.folder().join("nodes");
    let before = files(&nodes, "");
    let daemon = Peer::start(&name, "daemon");
    let node = files(&nodes, "")
        .into_iter()
        .find(|path| path.is_dir() && !before.contains(path))
        .expect("a node");
    daemon.kill();
    // State after a cleaner removed the tags and died before releasing the slots.
    let notes = observer
        .folder()
        .join("cleaning")
        .join(node.file_name().expect("a name"));
    fs::create_dir_all(&notes).expect("folder");
    let tags = files(&node, ".port_tag");
    assert_eq!(tags.len(), 4, "iceoryx2 uses these file names");
    for tag in tags {
        fs::rename(&tag, notes.join(tag.file_name().expect("a name"))).expect("moved");
    }
    drop(start_daemon(&name));
    assert!(
        !observer.folder().join("cleaning").exists(),
        "the backup is gone"
    );
}

#[test]
fn clean_up_killed_at_last_step_is_completed() {
    let name = FreshBus::new("laststep");
    let observer = open(&name, "observer");
    let nodes = observer.folder().join("nodes");
    let before = files(&nodes, "");
    let member = Peer::start(&name, "member");
    let new = files(&nodes, "")
        .into_iter()
        .filter(|path| !before.contains(path));
    let (folders, monitors): (Vec<_>, Vec<_>) = new.partition(|path| path.is_dir());
    member.kill();
    fs::remove_dir_all(&folders[0]).expect("removed");
    assert!(
        monitors.iter().all(|path| path.exists()),
        "the monitors remain"
    );
    assert_eq!((observer.clean_dead(), observer.clean_dead()), (1, 0));
    assert!(!monitors.iter().any(|path| path.exists()));
    assert_eq!(observer.peers().expect("listed").len(), 1);
}

#[test]
fn unfinished_node_counter_does_not_block() {
    let name = FreshBus::new("counter");
    let observer = open(&name, "observer");
    let counters = memory(&name, "mgmt");
    assert!(
        !counters.is_empty(),
        "iceoryx2 uses these file names: {:?}",
        memory(&name, "")
    );
    for path in &counters {
        fs::remove_file(path).expect("removed");
        fs::write(path, "").expect("an empty file");
    }
    open(&name, "second");
    drop(observer);
}

#[test]
fn dead_peers_are_listed_and_removed() {
    let name = FreshBus::new("dead");
    let bus = open(&name, "supervisor");
    let daemon = Peer::start(&name, "daemon");
    let pid = daemon.pid();
    let find = || {
        bus.peers()
            .expect("listed")
            .into_iter()
            .find(|peer| peer.pid == pid)
    };
    let peer = find().expect("on the bus");
    assert_eq!((peer.role.as_str(), peer.alive), ("atasd", true));
    assert_eq!(bus.clean_dead(), 0, "no peer is dead");
    daemon.kill();
    assert!(!find().expect("still listed").alive);
    until("the dead are removed", || bus.clean_dead() == 1);
    assert_eq!(find(), None);
    let alive = bus.peers().expect("listed");
    assert_eq!(alive.len(), 1);
    assert_eq!(
        (alive[0].role.as_str(), alive[0].pid),
        ("supervisor", std::process::id())
    );
}

#[test]
fn second_daemon_is_rejected_naming_the_first() {
    let name = FreshBus::new("owner");
    let holder = Peer::start(&name, "holder");
    let refused = OwnerLock::take(&name, "atasd").expect_err("owned");
    let BusError::Owned { pid, role, .. } = &refused else {
        panic!("{refused}")
    };
    assert_eq!((*pid, role.as_str()), (holder.pid(), "holder"));
    assert!(
        matches!(Bus::wipe(&name), Err(BusError::Owned { .. })),
        "an owned bus is not wiped"
    );
    holder.kill();
    let owner = OwnerLock::take(&name, "atasd").expect("the lock ends with its process");
    assert!(
        OwnerLock::take(&name, "atasd").is_err(),
        "the same process cannot own it twice"
    );
    drop(owner);
    OwnerLock::take(&name, "atasd").expect("free again");
}
