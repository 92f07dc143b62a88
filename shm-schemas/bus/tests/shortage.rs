//! A process without resources gets an error that names them and does not affect other processes.

mod common;

use std::fs;

use common::{Peer, peer_role, ready, sleep_until_killed};
use rustix::process::{Resource, Rlimit, getrlimit, setrlimit};
use shm_bus::{Bus, BusError, BusName, FreshBus, Realtime};
use shm_schemas::service::STATUS;
use shm_schemas::{RunHeader, Status};

fn observe(name: &BusName) -> Result<(), BusError> {
    let bus = Bus::join(name, "observer", Realtime::No)?;
    let _status = bus.subscriber::<Status>(STATUS)?;
    let _header = bus.subscriber::<RunHeader>(shm_schemas::service::RUN_HEADER)?;
    let _client = bus.control_client()?;
    Ok(())
}

/// Limits this process to `more` descriptors beyond those in use.
fn allow_descriptors(more: u64) {
    let used = fs::read_dir("/proc/self/fd").expect("listed").count() as u64 - 1;
    let limit = Rlimit {
        current: Some(used + more),
        ..getrlimit(Resource::Nofile)
    };
    setrlimit(Resource::Nofile, limit).expect("below the hard limit");
}

#[test]
fn peer() {
    let Some((role, name)) = peer_role() else {
        return;
    };
    match role.as_str() {
        "daemon" => {
            let bus = Bus::open(&name, "atasd", Realtime::No).expect("opens");
            let _status = bus.publisher::<Status>(STATUS).expect("publisher");
            let _control = bus.control_server().expect("server");
            sleep_until_killed();
        }
        "poor" => {
            let (mut refused, mut served) = (0, 0);
            for more in 0..40 {
                allow_descriptors(more);
                match observe(&name) {
                    Ok(()) => served += 1,
                    Err(refusal) => {
                        let text = refusal.to_string();
                        assert!(
                            text.contains("file descriptors")
                                || text.contains("Too many open files"),
                            "{more} descriptors: {text}"
                        );
                        refused += 1;
                    }
                }
            }
            assert!(
                refused > 5 && served > 0,
                "{refused} refused, {served} served"
            );
            ready();
        }
        other => panic!("no role {other}"),
    }
}

#[test]
fn descriptor_shortage_is_reported_and_harmless() {
    let name = FreshBus::new("poor");
    let _daemon = Peer::start(&name, "daemon");
    Peer::spawn(&name, "poor").succeed();
    observe(&name).expect("the bus is unaffected");
    let bus = Bus::join(&name, "second", Realtime::No).expect("joins");
    let taken = bus
        .publisher::<Status>(STATUS)
        .expect_err("the daemon still has it");
    assert!(matches!(taken, BusError::Taken { .. }), "{taken}");
}

#[test]
fn small_stack_is_rejected() {
    let name = FreshBus::new("stack");
    let _bus = Bus::open(&name, "first", Realtime::No).expect("opens");
    let (mut refused, mut served) = (0, 0);
    for kib in (64..=1024).step_by(32) {
        let name = BusName::clone(&name);
        let thread = std::thread::Builder::new().stack_size(kib << 10);
        let tried = thread
            .spawn(move || observe(&name))
            .expect("spawned")
            .join();
        match tried.expect("no panic") {
            Ok(()) => served += 1,
            Err(BusError::Shortage { why, .. }) => {
                assert!(why.contains("stack"), "{why}");
                refused += 1;
            }
            Err(other) => panic!("{kib} KiB: {other}"),
        }
    }
    assert!(
        refused > 0 && served > 0,
        "{refused} refused, {served} served"
    );
}
