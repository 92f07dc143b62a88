//! A bus is alone: other buses, other users and iceoryx2's own defaults stay out of it.

use std::fs;
use std::os::unix::fs::MetadataExt;
use std::path::Path;

use cargo_metadata::MetadataCommand;
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
        .expect("one writer per bus, not per machine");
    let mut subscriber = there.subscriber::<Status>(STATUS).expect("subscriber");
    publisher.send(&Status::default()).expect("sent");
    assert_eq!(subscriber.drain(10, |_| {}).expect("drained"), 0);
    other.send(&Status::default()).expect("sent");
    assert_eq!(subscriber.drain(10, |_| {}).expect("drained"), 1);
    assert_eq!(there.peers().expect("listed").len(), 1);
}

#[test]
fn nobody_else_may_read_or_write() {
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
fn wiping_leaves_nothing_and_spares_the_living() {
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

/// A feature of a dependency is chosen in the manifests of the workspace, so these are what is looked at; the test
/// above looks at what iceoryx2 then does.
#[test]
fn the_bus_is_never_opened_to_every_user() {
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
    assert!(!iceoryx2.is_empty(), "the workspace was looked at");
    for dependency in iceoryx2 {
        let opened = dependency
            .features
            .iter()
            .any(|feature| feature == "dev_permissions");
        assert!(
            !opened,
            "remove dev_permissions from {}: it gives every user every bus",
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
