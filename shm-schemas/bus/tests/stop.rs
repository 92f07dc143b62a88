//! A stop request reaches the daemon in every state of the bus.

mod common;

use std::fs;
use std::io::{self, Write};
use std::os::unix::net::UnixDatagram;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use common::{
    PRIVATE_RUNTIME_DIR, Peer, hold_startup_lock, peer_role, ready, sleep_until_killed, until,
};
use rustix::process::{Resource, Rlimit, Signal as Signum, getrlimit, setrlimit};
use shm_bus::stop::{self, Listener};
use shm_bus::{Bus, BusError, BusName, FreshBus, OwnerLock, Realtime};
use shm_schemas::{GoalRequest, StopOutcome};

const WITHIN: Duration = Duration::from_secs(5);

fn folder(name: &BusName) -> PathBuf {
    let bus = Bus::join(name, "looker", Realtime::No).expect("the bus is there");
    bus.folder().to_owned()
}

/// A daemon with a bus, its servers, a listener, and a tick that polls every millisecond. `shows`:
/// the status shows the stops.
fn daemon(name: &BusName, ticks: bool, shows: bool) {
    let owner = OwnerLock::take(name, "atasd").expect("sole owner");
    let listener = Arc::new(Listener::open(&owner).expect("a listener"));
    let bus = Bus::open(name, "atasd", Realtime::No).expect("the bus opens");
    let _servers = (
        bus.goal_server().expect("goals"),
        bus.control_server().expect("control"),
    );
    let signal = listener.signal();
    let server = Arc::clone(&listener);
    std::thread::spawn(move || server.serve(|_| {}));
    ready();
    loop {
        if let Some(number) = signal.pending().filter(|_| ticks) {
            signal.take(number);
            if shows {
                signal.show(number);
            }
        }
        std::thread::sleep(Duration::from_millis(1));
    }
}

#[test]
fn peer() {
    let Some((role, name)) = peer_role() else {
        return;
    };
    match role.as_str() {
        "daemon" => daemon(&name, true, true),
        "frozen" => daemon(&name, false, true),
        "with a hung supervisor" => daemon(&name, true, false),
        "on small disks" => {
            let _daemon = Peer::start(&name, "daemon");
            let folder = folder(&name);
            assert!(
                folder.starts_with(PRIVATE_RUNTIME_DIR),
                "{folder:?} is not the private folder"
            );
            fill(&folder);
            fill(Path::new("/dev/shm"));
            let late = Bus::join(&name, "late", Realtime::No).expect_err("no room to join");
            assert!(late.to_string().contains("0 KiB free"), "{late}");
            check_stopped(&name, 100);
        }
        "poor" => {
            // Exhausts all descriptors, as too many observers would.
            let owner = OwnerLock::take(&name, "atasd").expect("sole owner");
            let listener = Listener::open(&owner).expect("a listener");
            let signal = listener.signal();
            let used = fs::read_dir("/proc/self/fd").expect("listed").count() as u64;
            let limit = Rlimit {
                current: Some(used + 8),
                ..getrlimit(Resource::Nofile)
            };
            setrlimit(Resource::Nofile, limit).expect("below the hard limit");
            let _all: Vec<_> = std::iter::from_fn(|| fs::File::open("/dev/null").ok()).collect();
            std::thread::spawn(move || {
                loop {
                    signal.pending().inspect(|number| signal.take(*number));
                    std::thread::sleep(Duration::from_millis(1));
                }
            });
            ready();
            listener.serve(|_| {});
        }
        "control clients" => {
            let bus = Bus::join(&name, "idle", Realtime::No).expect("joins");
            let _clients: Vec<_> = (0..16)
                .map(|_| bus.control_client().expect("a slot"))
                .collect();
            assert!(matches!(bus.control_client(), Err(BusError::Full { .. })));
            sleep_until_killed();
        }
        "goal clients" => {
            let bus = Bus::join(&name, "greedy", Realtime::No).expect("joins");
            let clients: Vec<_> = (0..8).map(|_| bus.goal_client().expect("a slot")).collect();
            let send = |client| shm_bus::GoalClient::send(client, &GoalRequest::default());
            let _pending: Vec<_> = clients
                .iter()
                .flat_map(|client| [send(client), send(client)])
                .map(|sent| sent.expect("sent"))
                .collect();
            assert!(matches!(bus.goal_client(), Err(BusError::Full { .. })));
            sleep_until_killed();
        }
        "starting" => hold_startup_lock(&name),
        "asking" => {
            ready();
            let _unheard = stop::request(&name, "a test", WITHIN);
            sleep_until_killed();
        }
        "in a container" => check_answered(&name),
        "flooder" => {
            let socket = UnixDatagram::unbound().expect("a socket");
            socket
                .connect(folder(&name).join("stop"))
                .expect("the socket is there");
            ready();
            while socket.send(&[7; 33]).is_ok() {}
        }
        other => panic!("no role {other}"),
    }
}

fn fill(folder: &Path) {
    let full = |e: io::Error| assert_eq!(e.kind(), io::ErrorKind::StorageFull, "{e}");
    let mut ballast = fs::File::create(folder.join("ballast")).expect("room for a first file");
    while let Ok(written) = ballast.write(&[0; 4096]) {
        assert_eq!(written, 4096);
    }
    let error = (0..)
        .find_map(|number| fs::File::create(folder.join(format!("ballast-{number}"))).err())
        .expect("finite");
    full(error);
    full(ballast.write(&[0]).expect_err("no byte is left"));
}

fn check_stopped(name: &BusName, times: usize) {
    for _ in 0..times {
        let answer = stop::request(name, "a test", WITHIN).expect("answered");
        assert_eq!(answer.outcome, StopOutcome::STOPPED);
    }
}

/// 1000 stops, whether or not a tick of a loaded machine takes them in time.
fn check_answered(name: &BusName) {
    for number in 1..=1000 {
        let answer = stop::request(name, "a test", WITHIN).expect("answered");
        assert_eq!(answer.stamp.sequence, number);
    }
}

/// The kernel reports a sender outside the daemon's PID namespace as process 0.
#[test]
fn stop_into_and_out_of_a_container_is_answered() {
    let (inside, outside) = (FreshBus::new("stopin"), FreshBus::new("stopout"));
    let Some(daemon) = Peer::spawn_in_namespaces(&inside, "daemon") else {
        return;
    };
    let daemon = daemon.until_ready();
    check_answered(&inside);
    daemon.kill();
    let daemon = Peer::start(&outside, "daemon");
    let client = Peer::spawn_in_namespaces(&outside, "in a container").expect("as before");
    client.succeed();
    daemon.kill();
}

#[test]
fn every_stop_is_counted_and_answered() {
    let name = FreshBus::new("stop");
    let daemon = Peer::start(&name, "daemon");
    let folder = folder(&name);
    let before = fs::read_dir(&folder).expect("listed").count();
    for number in 1..=100 {
        let answer = stop::request(&name, "a test", WITHIN).expect("answered");
        assert_eq!(
            (answer.stamp.sequence, answer.outcome, answer.pid),
            (number, StopOutcome::STOPPED, daemon.pid())
        );
    }
    assert_eq!(fs::read_dir(&folder).expect("listed").count(), before);
}

#[test]
fn stop_arrives_on_a_full_locked_bus() {
    let name = FreshBus::new("crowded");
    let _daemon = Peer::start(&name, "daemon");
    let _crowd = ["control clients", "goal clients"].map(|role| Peer::start(&name, role));
    let starting = Peer::start(&name, "starting");
    starting.stop();
    let refused = Bus::join(&name, "late", Realtime::No).expect_err("the start-up lock is held");
    assert!(
        matches!(&refused, BusError::StartupBlocked { pid, .. } if *pid == starting.pid()),
        "{refused}"
    );
    check_stopped(&name, 200);
}

#[test]
fn junk_flood_does_not_block_stops() {
    let name = FreshBus::new("flood");
    let _daemon = Peer::start(&name, "daemon");
    let _flood = [0; 3].map(|_| Peer::start(&name, "flooder"));
    check_stopped(&name, 20);
}

/// The answers to the flood wait for the status, and no answer waits for another.
#[test]
fn flood_with_a_hung_supervisor_does_not_delay_answers() {
    let name = FreshBus::new("hung");
    let _daemon = Peer::start(&name, "with a hung supervisor");
    let _flood = Peer::start(&name, "flooder");
    let request = || stop::request(&name, "a test", WITHIN).expect("answered");
    let stops = std::thread::scope(|threads| {
        let senders = [0; 20].map(|_| threads.spawn(request));
        senders.map(|sender| sender.join().expect("no panic"))
    });
    assert!(stops.iter().all(|s| s.outcome == StopOutcome::STOPPED));
}

#[test]
fn stop_arrives_without_free_descriptors() {
    let name = FreshBus::new("poor");
    let _daemon = Peer::start(&name, "poor");
    check_stopped(&name, 20);
}

#[test]
fn stop_arrives_with_full_file_systems() {
    let name = FreshBus::new("fulldisk");
    let Some(peer) = Peer::spawn_on_small_file_systems(&name, "on small disks") else {
        return;
    };
    peer.succeed();
}

#[test]
fn frozen_tick_gives_outcome_waiting() {
    let name = FreshBus::new("frozen");
    let _daemon = Peer::start(&name, "frozen");
    let answer = stop::request(&name, "a test", WITHIN).expect("answered");
    assert_eq!(answer.outcome, StopOutcome::WAITING);
}

#[test]
fn stop_waits_for_a_suspended_daemon() {
    let name = FreshBus::new("asleep");
    let daemon = Peer::start(&name, "daemon");
    daemon.stop();
    let unheard = stop::request(&name, "a test", Duration::from_millis(50)).expect_err("asleep");
    assert!(matches!(unheard, BusError::NoAnswer { .. }), "{unheard}");
    daemon.signal(Signum::CONT);
    let second = stop::request(&name, "a test", WITHIN).expect("answered");
    assert_eq!(second.stamp.sequence, 2, "the first stop counted as well");
}

#[test]
fn sockets_of_killed_clients_are_removed_by_the_next_daemon() {
    let name = FreshBus::new("sockets");
    let daemon = Peer::start(&name, "daemon");
    daemon.stop();
    // The bus outlives the daemon.
    let observer = Bus::join(&name, "observer", Realtime::No).expect("joins");
    let folder = observer.folder();
    let sockets = || {
        let entries = fs::read_dir(folder).expect("listed").flatten();
        let names = entries.map(|entry| entry.file_name().into_string().expect("UTF-8"));
        let mut clients: Vec<String> = names.filter(|name| name.starts_with("stop-")).collect();
        clients.sort();
        clients
    };
    let clients = [0; 3].map(|_| Peer::start(&name, "asking"));
    until("all wait", || sockets().len() == 3);
    clients.into_iter().for_each(Peer::kill);
    daemon.kill();
    let _waiting = UnixDatagram::bind(folder.join("stop-waiting")).expect("a living client");
    assert_eq!(sockets().len(), 4);
    let _next = Peer::start(&name, "daemon");
    assert_eq!(sockets(), ["stop-waiting"]);
}

#[test]
fn stop_without_daemon_names_the_cause() {
    let name = FreshBus::new("nobody");
    let nothing = stop::request(&name, "a test", WITHIN).expect_err("no bus");
    assert!(
        matches!(
            nothing,
            BusError::Absent { .. } | BusError::OtherUser { .. }
        ),
        "{nothing}"
    );
    let daemon = Peer::start(&name, "daemon");
    daemon.kill();
    let nobody = stop::request(&name, "a test", WITHIN).expect_err("no daemon");
    assert!(matches!(nobody, BusError::NoServer { .. }), "{nobody}");
    let _next = Peer::start(&name, "daemon");
    check_stopped(&name, 1);
}

#[test]
fn closing_ends_the_thread() {
    let name = FreshBus::new("close");
    let owner = OwnerLock::take(&name, "test").expect("sole owner");
    let listener = Arc::new(Listener::open(&owner).expect("a listener"));
    let ended = Arc::new(AtomicBool::new(false));
    let (server, done) = (Arc::clone(&listener), Arc::clone(&ended));
    std::thread::spawn(move || {
        server.serve(|_| {});
        done.store(true, Ordering::Release);
    });
    std::thread::sleep(Duration::from_millis(5));
    listener.close();
    until("the thread has ended", || ended.load(Ordering::Acquire));
}
