//! Isolation of a bus from other buses, other users and iceoryx2's defaults.

mod common;

use std::collections::HashSet;
use std::fs;
use std::io::ErrorKind;
use std::os::unix::fs::MetadataExt;
use std::os::unix::net::UnixDatagram;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use cargo_metadata::MetadataCommand;
use common::{Peer, peer_role, ready};
use shm_bus::{Bus, BusError, BusName, FreshBus, Realtime};
use shm_schemas::Status;
use shm_schemas::service::STATUS;

fn open(bus: &BusName, role: &str) -> Bus {
    Bus::open(bus, role, Realtime::No).expect("the bus opens")
}

fn memory(name: &BusName) -> Vec<std::path::PathBuf> {
    let all = fs::read_dir("/dev/shm")
        .expect("readable")
        .flatten()
        .map(|entry| entry.path());
    all.filter(|path| path.to_string_lossy().contains(&format!("/{name}_")))
        .collect()
}

#[test]
fn two_buses_do_not_see_each_other() {
    let (left, right) = (FreshBus::new("left"), FreshBus::new("right"));
    let (here, there) = (open(&left, "here"), open(&right, "there"));
    let publisher = here.publisher::<Status>(STATUS).expect("publisher");
    let other = there
        .publisher::<Status>(STATUS)
        .expect("each bus has its own writer");
    let mut subscriber = there.subscriber::<Status>(STATUS).expect("subscriber");
    publisher.send(&Status::default()).expect("sent");
    assert_eq!(subscriber.drain(10, |_| {}).expect("drained"), 0);
    other.send(&Status::default()).expect("sent");
    assert_eq!(subscriber.drain(10, |_| {}).expect("drained"), 1);
    assert_eq!(there.peers().expect("listed").len(), 1);
}

#[test]
fn last_process_leaves_no_shared_memory() {
    let name = FreshBus::new("leave");
    for _ in 0..3 {
        let (first, second) = (open(&name, "first"), open(&name, "second"));
        let publisher = first.publisher::<Status>(STATUS).expect("publisher");
        drop(first);
        drop(second);
        assert!(!memory(&name).is_empty(), "the publisher is in use");
        publisher.send(&Status::default()).expect("sent");
        drop(publisher);
        assert_eq!(memory(&name), Vec::<std::path::PathBuf>::new());
    }
}

#[test]
fn files_are_private_to_the_user() {
    let name = FreshBus::new("private");
    let bus = open(&name, "both");
    let _publisher = bus.publisher::<Status>(STATUS).expect("publisher");
    let _subscriber = bus.subscriber::<Status>(STATUS).expect("subscriber");
    assert_eq!(
        fs::metadata(bus.folder()).expect("folder").mode() & 0o077,
        0
    );
    let memory = memory(&name);
    assert!(!memory.is_empty());
    for path in &memory {
        assert_eq!(
            fs::metadata(path).expect("memory").mode() & 0o077,
            0,
            "{}",
            path.display()
        );
    }
}

#[test]
fn wipe_removes_all_of_an_unused_bus() {
    let name = BusName::fresh("wipe");
    let bus = open(&name, "alive");
    let folder = bus.folder().to_owned();
    let publisher = bus.publisher::<Status>(STATUS).expect("publisher");
    let refused = Bus::wipe(&name).expect_err("in use");
    assert!(
        matches!(&refused, BusError::InUse { peers, .. } if peers.contains("alive")),
        "{refused}"
    );
    publisher
        .send(&Status::default())
        .expect("the bus still works");
    drop((publisher, bus));
    Bus::wipe(&name).expect("wiped");
    assert!(!folder.exists());
    assert_eq!(memory(&name), Vec::<std::path::PathBuf>::new());
    Bus::wipe(&name).expect("an empty bus is wiped as well");
}

/// Checks the workspace's manifests, which select the features of iceoryx2; the test above checks
/// the resulting modes.
#[test]
fn dev_permissions_is_not_enabled() {
    let manifest = Path::new(env!("CARGO_MANIFEST_DIR")).join("Cargo.toml");
    let metadata = MetadataCommand::new()
        .manifest_path(manifest)
        .no_deps()
        .exec()
        .expect("cargo metadata");
    let dependencies = metadata
        .packages
        .iter()
        .flat_map(|package| &package.dependencies);
    let iceoryx2: Vec<_> = dependencies
        .filter(|dependency| dependency.name.starts_with("iceoryx2"))
        .collect();
    assert!(!iceoryx2.is_empty(), "iceoryx2 is a dependency");
    for dependency in iceoryx2 {
        let opened = dependency
            .features
            .iter()
            .any(|feature| feature == "dev_permissions");
        assert!(
            !opened,
            "remove dev_permissions from {}: it opens every bus to every user",
            dependency.name
        );
    }
    let own = metadata
        .packages
        .iter()
        .flat_map(|package| package.features.values().flatten());
    let passed_on: Vec<_> = own
        .filter(|feature| feature.contains("dev_permissions"))
        .collect();
    assert_eq!(
        passed_on,
        Vec::<&String>::new(),
        "remove the feature that passes dev_permissions on"
    );
}

/// iceoryx2 alone opens its node counter to every user for a moment at each start.
#[test]
fn files_are_private_from_creation() {
    let name = FreshBus::new("moment");
    let (watched, done) = (BusName::clone(&name), Arc::new(AtomicBool::new(false)));
    let ended = Arc::clone(&done);
    let watch = std::thread::spawn(move || {
        let (mut seen, mut open) = (0, Vec::new());
        while !ended.load(Ordering::Acquire) {
            for path in memory(&watched) {
                let Ok(meta) = fs::symlink_metadata(&path) else {
                    continue;
                };
                seen += 1;
                if meta.mode() & 0o077 != 0 {
                    open.push((path, meta.mode()));
                }
            }
        }
        (seen, open)
    });
    let mut prefixes = HashSet::new();
    for _ in 0..40 {
        prefixes.insert(open(&name, "starter").prefix().to_owned());
    }
    done.store(true, Ordering::Release);
    let (seen, open) = watch.join().expect("watched");
    assert!(seen > 0, "the watcher found shared memory");
    assert_eq!(open, Vec::new());
    assert_eq!(prefixes.len(), 40, "each life of a bus has a new prefix");
}

/// Runs a test that needs another user (`nobody`); requires root.
#[allow(clippy::print_stderr, reason = "reports that the test did not run")]
fn as_another_user(what: impl FnOnce(u32)) {
    if rustix::process::geteuid().is_root() {
        what(65534);
    } else {
        eprintln!("SKIPPED: only root can act as another user");
    }
}

#[test]
fn foreign_files_are_ignored() {
    as_another_user(|stranger| {
        let name = FreshBus::new("squat");
        let bus = open(&name, "here");
        // Names that another user can derive from the prefix and iceoryx2's naming scheme.
        let squatted = ["x", "node.0_10_0.y", "z.dynamic", "1.connection", "2.data"]
            .map(|rest| Path::new("/dev/shm").join(format!("{}{rest}", bus.prefix())));
        for path in &squatted {
            fs::write(path, "junk").expect("written");
            std::os::unix::fs::chown(path, Some(stranger), Some(stranger)).expect("given away");
        }
        let publisher = bus.publisher::<Status>(STATUS).expect("publisher");
        let second = Bus::join(&name, "second", Realtime::No).expect("joins");
        let mut subscriber = second.subscriber::<Status>(STATUS).expect("subscriber");
        publisher.send(&Status::default()).expect("sent");
        assert!(subscriber.newest(&mut Status::default()).expect("received"));
        drop((publisher, subscriber, second));
        assert_eq!(bus.clean_dead(), 0);
        let before = bus.prefix().to_owned();
        drop(bus);
        let next = open(&name, "next");
        assert_ne!(next.prefix(), before, "a new life has a new prefix");
        drop(next);
        for path in &squatted {
            assert!(path.exists(), "foreign files are kept");
            fs::remove_file(path).expect("removed");
        }
    });
}

#[test]
fn joining_a_missing_bus_creates_nothing() {
    let made = FreshBus::new("made");
    let base = open(&made, "here")
        .folder()
        .parent()
        .expect("a base")
        .to_owned();
    let mistyped = BusName::fresh("mistyped");
    let refused = Bus::join(&mistyped, "looker", Realtime::No).expect_err("no such bus");
    assert!(
        matches!(
            refused,
            BusError::Absent { .. } | BusError::OtherUser { .. }
        ),
        "{refused}"
    );
    assert!(!base.join(mistyped.as_str()).exists());
    assert_eq!(memory(&mistyped), Vec::<std::path::PathBuf>::new());
}

#[test]
fn peer() {
    let Some((role, name)) = peer_role() else {
        return;
    };
    assert_eq!(role, "stranger");
    let refused = Bus::join(&name, "stranger", Realtime::No).expect_err("bus of another user");
    let stopped = shm_bus::stop::request(&name, "a test", Duration::from_secs(1))
        .expect_err("other users cannot stop it");
    for error in [refused, stopped] {
        let BusError::OtherUser { user, place, .. } = &error else {
            panic!("{error}");
        };
        assert_eq!(user, "root");
        // The path names the prefix of all the bus's memory, not one file, and fits a table column.
        let (begin, drawn) = (format!("/dev/shm/{name}_"), "0123456789abcdef_*");
        let place = place.to_string_lossy();
        assert!(
            place.starts_with(&begin) && place.ends_with("_*"),
            "{place}"
        );
        assert_eq!(place.len(), begin.len() + drawn.len(), "{place}");
    }
    // For a missing bus, the error names the folders that this user may not read.
    let nowhere = BusName::fresh("nowhere");
    let absent = Bus::join(&nowhere, "stranger", Realtime::No).expect_err("no such bus");
    let output = absent.to_string();
    assert!(matches!(absent, BusError::Absent { .. }), "{output}");
    let part = "/dev/shm/atas-0 of user root";
    assert!(
        output.contains(part) && output.contains("may not see"),
        "{output}"
    );
    let socket = Path::new("/dev/shm/atas-0")
        .join(name.as_str())
        .join("stop");
    let denied = UnixDatagram::unbound().expect("a socket").connect(socket);
    assert_eq!(
        denied.expect_err("private").kind(),
        ErrorKind::PermissionDenied
    );
    ready();
}

#[test]
fn foreign_folder_is_named_if_it_has_bus() {
    as_another_user(|_| {
        let (user, name) = (60_631, BusName::fresh("stale"));
        let base = Path::new("/dev/shm").join(format!("atas-{user}"));
        let found = || {
            Bus::find(&name)
                .expect_err("no bus of this user")
                .to_string()
        };
        let make = |folder: &Path| {
            fs::create_dir(folder).expect("made");
            std::os::unix::fs::chown(folder, Some(user), Some(user)).expect("given away");
        };
        make(&base);
        let stale = found();
        make(&base.join(name.as_str()));
        let held = found();
        fs::remove_dir_all(&base).expect("removed");
        assert!(!stale.contains(&user.to_string()), "{stale}");
        assert!(held.contains(&format!("run this as {user}")), "{held}");
    });
}

#[test]
fn other_users_get_the_owner_but_no_access() {
    as_another_user(|stranger| {
        let name = FreshBus::new("owned");
        let _bus = open(&name, "here");
        Peer::spawn_as(&name, "stranger", stranger).succeed();
    });
}
