//! Process tests of `atas estop` while ordinary commands are blocked.
use std::fs::File;
use std::process::{Command, Output, Stdio};
use std::sync::Arc;
use std::time::Duration;

use rustix::fs::{FlockOperation, flock};
use shm_bus::stop::Listener;
use shm_bus::{Bus, FreshBus, OwnerLock, Realtime};

fn estop(bus: &FreshBus) -> (i32, String, String) {
    let mut command = Command::new(env!("CARGO_BIN_EXE_atas"));
    command.args(["estop", "--bus", bus.as_str()]);
    let Output {
        status,
        stdout,
        stderr,
    } = command
        .env_remove("RUST_LOG")
        .stdin(Stdio::null())
        .output()
        .expect("it starts");
    let text = |bytes| String::from_utf8(bytes).expect("UTF-8");
    (status.code().expect("a code"), text(stdout), text(stderr))
}

#[test]
fn estop_needs_no_lock_or_client_slot() {
    let name = FreshBus::new("estop");
    let owner = OwnerLock::take(&name, "atasd").expect("sole owner");
    let listener = Arc::new(Listener::open(&owner).expect("a listener"));
    let bus = Bus::open(&name, "atasd", Realtime::No).expect("the bus opens");
    let _places: Vec<_> = std::iter::from_fn(|| bus.control_client().ok()).collect();
    let lock = File::open(bus.folder().join("startup.lock")).expect("the lock is there");
    flock(&lock, FlockOperation::LockExclusive).expect("locked, as by a stopped client");
    let server = Arc::clone(&listener);
    let thread = std::thread::spawn(move || server.serve(|_| ()));
    let signal = listener.signal();
    let (code, stdout, stderr) = estop(&name);
    assert_eq!((code, stdout.as_str()), (1, ""), "nothing was stopped");
    for part in [
        "no tick took it",
        &format!("process {}", std::process::id()),
    ] {
        assert!(stderr.contains(part), "{stderr}");
    }
    let untaken = signal.pending().expect("the stop is pending");
    let ticks = std::thread::spawn(move || {
        let next = || signal.pending().filter(|number| *number > untaken);
        let number = loop {
            match next() {
                Some(number) => break number,
                None => std::thread::sleep(Duration::from_millis(1)),
            }
        };
        signal.take(number);
    });
    let (code, stdout, stderr) = estop(&name);
    assert_eq!(
        (code, stdout.trim_end()),
        (0, "stopped; `atas recover` re-arms"),
        "{stderr}"
    );
    ticks.join().expect("ticked");
    listener.close();
    thread.join().expect("served");
}

#[test]
fn estop_without_daemon_fails_without_leftovers() {
    let name = FreshBus::new("estopno");
    let (code, stdout, stderr) = estop(&name);
    assert_eq!((code, stdout.as_str()), (3, ""), "{stderr}");
    assert!(stderr.contains(name.as_str()), "{stderr}");
    let made = Bus::join(&name, "looker", Realtime::No);
    assert!(made.is_err(), "nothing was made");
}
