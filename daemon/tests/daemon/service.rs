//! The daemon under a service manager, and its configuration changing under it.

use std::fs;
use std::os::unix::net::UnixDatagram;

use rustix::process::Signal;
use shm_bus::FreshBus;
use shm_schemas::{ControlOp, ControlOutcome};
use tempfile::TempDir;

use crate::support::{Daemon, PATIENCE, World, wait_for};

#[test]
fn the_service_manager_hears_ready_watchdog_and_stopping() {
    let bus = FreshBus::new("notify");
    let folder = TempDir::new().expect("a temporary folder");
    let path = folder.path().join("notify");
    let socket = UnixDatagram::bind(&path).expect("bound");
    socket.set_read_timeout(Some(PATIENCE)).expect("set");
    let mut daemon = Daemon::start_with(&bus, "", &[], |command| {
        command
            .env("NOTIFY_SOCKET", &path)
            .env("WATCHDOG_USEC", "30000");
    });
    let hear = || {
        let mut buffer = [0; 256];
        let length = socket.recv(&mut buffer).expect("a message");
        String::from_utf8_lossy(&buffer[..length]).into_owned()
    };
    assert_eq!(hear().trim(), "READY=1");
    assert_eq!(hear().trim(), "WATCHDOG=1");
    daemon.signal(Signal::HUP);
    wait_for("reloading", || {
        hear()
            .starts_with("RELOADING=1\nMONOTONIC_USEC=")
            .then_some(())
    });
    wait_for("ready again", || (hear().trim() == "READY=1").then_some(()));
    daemon.signal(Signal::TERM);
    wait_for("stopping", || (hear().trim() == "STOPPING=1").then_some(()));
    let ended = daemon.wait();
    assert!(ended.success(), "{ended}");
}

#[test]
fn the_configuration_is_read_again_or_kept() {
    let bus = FreshBus::new("reload");
    let mut world = World::on(&bus);
    let mut daemon = Daemon::start_with(&bus, "", &[], |_| ());
    world.until("a status", |s| s.ticks > 0);
    let get = |world: &mut World| world.control(ControlOp::PARAM_GET, "grasp.dr_n", 0.0).value;
    let write = |text: &str| fs::write(daemon.config_file(), text).expect("writable");

    write("grasp.dr_n = 0.1");
    daemon.signal(Signal::HUP);
    wait_for("the new value", || (get(&mut world) == 0.1).then_some(()));

    let mut check_refused = |text: &str, said: &str| {
        write(text);
        let reply = world.control(ControlOp::RELOAD, "", 0.0);
        assert_eq!(reply.outcome, ControlOutcome::REFUSED);
        assert!(reply.text.as_str().contains(said), "{}", reply.text);
        assert_eq!(get(&mut world), 0.1, "nothing changed");
    };
    check_refused(
        "grasp.dr_n = 0.2\nrealtime.rate_hz = 500",
        "could not change realtime.rate_hz while running",
    );
    check_refused("grasp.dr_n = 0.2\ngrasp.slip_on = 9", "grasp.slip_on is 9");

    write("grasp.dr_n = 0.3");
    assert_eq!(
        world.control(ControlOp::RELOAD, "", 0.0).outcome,
        ControlOutcome::DONE
    );
    assert_eq!(get(&mut world), 0.3);
    assert!(daemon.is_running());
}
