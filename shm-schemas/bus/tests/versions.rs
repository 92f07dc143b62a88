//! Programs of different ABI refuse each other and name both versions.

mod common;

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

use common::{Peer, peer_role, sleep_until_killed};
use shm_bus::stop::{self, Listener};
use shm_bus::{Abi, Bus, BusError, BusName, FreshBus, OwnerLock, Realtime, long_version};
use shm_schemas::service::STATUS;
use shm_schemas::{Status, StopOutcome};

/// Version of another program, as it would write it.
const OTHER: &str = "atas 0.2.0 (ABI v9 0x0123456789abcdef)";
const GOLDEN: &str = include_str!("abi.golden");

fn open(bus: &BusName, role: &str) -> Result<Bus, BusError> {
    Bus::open(bus, role, Realtime::No)
}

fn version_file(bus: &Bus) -> PathBuf {
    bus.folder().join("version")
}

/// Version of this program on a bus.
fn own_version() -> String {
    let product = env!("CARGO_PKG_VERSION");
    format!("atas {product} (ABI {})", Abi::current())
}

/// Makes a running bus look as if a program of another version had created it.
fn pretend_other_version(file: &Path) {
    fs::write(file, format!("{OTHER}\n")).expect("written");
}

/// Asserts that the error names both versions and a process that uses the bus.
fn assert_names_both(error: &BusError, peer: &str) {
    assert!(matches!(error, BusError::OtherVersion { .. }), "{error}");
    let text = error.to_string();
    for part in [OTHER, &own_version(), peer, "install the same version"] {
        assert!(text.contains(part), "{part:?} is missing in: {text}");
    }
}

#[test]
fn peer() {
    let Some((role, name)) = peer_role() else {
        return;
    };
    let _owner = OwnerLock::take(&name, &role).expect("sole owner");
    sleep_until_killed();
}

#[test]
fn client_and_daemon_of_other_abi_are_refused() {
    let name = FreshBus::new("other");
    let daemon = open(&name, "atasd").expect("a new bus");
    let publisher = daemon.publisher::<Status>(STATUS).expect("publisher");
    let file = version_file(&daemon);
    pretend_other_version(&file);
    let peer = format!("atasd (process {})", std::process::id());
    let client = Bus::join(&name, "client", Realtime::No).expect_err("another ABI");
    assert_names_both(&client, &peer);
    assert_names_both(&open(&name, "second").expect_err("another ABI"), &peer);
    assert_eq!(daemon.peers().expect("listed").len(), 1);
    publisher
        .send(&Status::default())
        .expect("the bus still works");
}

#[test]
fn other_product_version_with_equal_abi_joins() {
    let name = FreshBus::new("equal");
    let daemon = open(&name, "atasd").expect("a new bus");
    let publisher = daemon.publisher::<Status>(STATUS).expect("publisher");
    let other = format!("atas 9.9.9 (ABI {})\n", Abi::current());
    fs::write(version_file(&daemon), other).expect("written");
    let client = Bus::join(&name, "client", Realtime::No).expect("an equal ABI");
    let mut statuses = client.subscriber::<Status>(STATUS).expect("subscriber");
    publisher.send(&Status::default()).expect("sent");
    assert!(statuses.newest(&mut Status::default()).expect("received"));
}

#[test]
fn bus_without_version_is_refused_while_in_use() {
    let name = FreshBus::new("missing");
    let daemon = open(&name, "atasd").expect("a new bus");
    fs::remove_file(version_file(&daemon)).expect("removed");
    let refused = open(&name, "client").expect_err("an unknown ABI");
    assert!(
        refused.to_string().contains("an unknown version of atas"),
        "{refused}"
    );
}

#[test]
fn unused_bus_gets_the_version_of_its_next_user() {
    let name = FreshBus::new("life");
    let former = open(&name, "former").expect("a new bus");
    let file = version_file(&former);
    pretend_other_version(&file);
    drop(former);
    let _next = open(&name, "next").expect("no process is on the bus");
    let written = fs::read_to_string(&file).expect("readable");
    assert_eq!(written, format!("{}\n", own_version()));
}

/// The daemon's lock shows that it runs, even if its nodes have the format of another iceoryx2.
#[test]
fn daemon_with_invisible_nodes_is_not_displaced() {
    let name = FreshBus::new("hidden");
    let former = open(&name, "former").expect("a new bus");
    let file = version_file(&former);
    let prefix_file = former.folder().join("prefix");
    let prefix = fs::read(&prefix_file).expect("readable");
    drop(former);
    // The invisible nodes use it.
    fs::write(&prefix_file, prefix).expect("writable");
    let owner = Peer::start(&name, "atasd");
    pretend_other_version(&file);
    // Longer than a start-up may take.
    std::thread::sleep(Duration::from_millis(2100));
    let refused = open(&name, "client").expect_err("another ABI");
    assert_names_both(&refused, &format!("atasd (process {})", owner.pid()));
    owner.kill();
    open(&name, "client").expect("a dead daemon uses nothing");
}

#[test]
fn stop_reaches_a_daemon_of_other_abi() {
    let name = FreshBus::new("stop");
    let owner = OwnerLock::take(&name, "atasd").expect("sole owner");
    let listener = Arc::new(Listener::open(&owner).expect("a listener"));
    let daemon = open(&name, "atasd").expect("a new bus");
    pretend_other_version(&version_file(&daemon));
    let (signal, server) = (listener.signal(), Arc::clone(&listener));
    let served = std::thread::spawn(move || server.serve(|_| {}));
    let ticks = std::thread::spawn(move || {
        loop {
            if let Some(number) = signal.pending() {
                signal.take(number);
                return;
            }
            std::thread::sleep(Duration::from_millis(1));
        }
    });
    let answer = stop::request(&name, "a test", Duration::from_secs(5)).expect("an answer");
    assert_eq!(answer.outcome, StopOutcome::STOPPED);
    ticks.join().expect("a stop arrived");
    listener.close();
    served.join().expect("the listener ends");
}

#[test]
fn abi_changes_only_with_its_golden_line() {
    let lines: Vec<&str> = GOLDEN
        .lines()
        .filter(|line| !line.starts_with('#'))
        .collect();
    for (line, number) in lines.iter().zip(1..) {
        assert!(line.starts_with(&format!("v{number} 0x")), "{line}");
    }
    let (last, current) = (lines.last().copied(), Abi::current());
    assert_eq!(
        last.and_then(|line| line.split_once(' '))
            .map(|(_, hash)| hash),
        Some(format!("0x{:016x}", current.hash).as_str()),
        "the layout of the bus has changed: raise Abi::NUMBER, append its line to abi.golden, and \
         add an entry to CHANGELOG.md"
    );
    assert_eq!(last, Some(current.to_string().as_str()));
}

#[test]
fn long_version_names_product_and_abi() {
    let version = long_version();
    assert!(
        version.starts_with(concat!(env!("CARGO_PKG_VERSION"), " (")),
        "{version}"
    );
    let end = format!(", ABI {})", Abi::current());
    assert!(version.ends_with(&end), "{version}");
}
