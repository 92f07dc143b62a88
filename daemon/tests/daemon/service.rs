//! The daemon under a service manager, and reloads of its configuration.

use std::fs;
use std::os::unix::net::UnixDatagram;
use std::process::Command;
use std::time::Duration;

use rustix::process::Signal;
use shm_bus::FreshBus;
use shm_schemas::{ControlOp, ControlOutcome, Mode};
use tempfile::TempDir;

use crate::support::{Daemon, TIMEOUT, World, wait_for};

struct Manager {
    folder: TempDir,
    socket: UnixDatagram,
}

impl Manager {
    fn new() -> Self {
        let folder = TempDir::new().expect("a temporary folder");
        let socket = UnixDatagram::bind(folder.path().join("notify")).expect("bound");
        socket.set_read_timeout(Some(TIMEOUT)).expect("set");
        Self { folder, socket }
    }

    fn set_environment(&self, command: &mut Command) {
        command
            .env("NOTIFY_SOCKET", self.folder.path().join("notify"))
            .env("WATCHDOG_USEC", "30000");
    }

    fn receive(&self) -> std::io::Result<String> {
        let mut buffer = [0; 256];
        let length = self.socket.recv(&mut buffer)?;
        Ok(String::from_utf8_lossy(&buffer[..length]).trim().to_owned())
    }
}

#[test]
fn watchdog_is_not_fed_without_ticks() {
    let bus = FreshBus::new("starve");
    let mut world = World::open(&bus);
    let manager = Manager::new();
    let _daemon = Daemon::start_with(&bus, "", &["--lockstep"], |c| manager.set_environment(c));
    manager.socket.set_nonblocking(true).expect("set");
    let mut tick = 0;
    wait_for("a fed watchdog", || {
        tick += 1;
        world.publish(tick * 1_000_000);
        (manager.receive().ok()? == "WATCHDOG=1").then_some(())
    });
    // Payloads already published may still cause a tick; then none follows.
    let quiet = Duration::from_millis(200);
    manager.socket.set_nonblocking(false).expect("set");
    manager.socket.set_read_timeout(Some(quiet)).expect("set");
    let last_words: Vec<_> = std::iter::from_fn(|| manager.receive().ok())
        .take(50)
        .collect();
    assert!(last_words.len() < 50, "fed without ticks: {last_words:?}");
}

#[test]
fn service_manager_receives_all_notifications() {
    let bus = FreshBus::new("notify");
    let manager = Manager::new();
    let mut daemon = Daemon::start_with(&bus, "", &[], |c| manager.set_environment(c));
    let next_message = || manager.receive().expect("a message");
    assert_eq!(next_message(), "READY=1");
    assert_eq!(next_message(), "WATCHDOG=1");
    daemon.signal(Signal::HUP);
    wait_for("reloading", || {
        next_message()
            .starts_with("RELOADING=1\nMONOTONIC_USEC=")
            .then_some(())
    });
    wait_for("ready again", || {
        (next_message() == "READY=1").then_some(())
    });
    daemon.signal(Signal::TERM);
    wait_for("stopping", || {
        (next_message() == "STOPPING=1").then_some(())
    });
    let ended = daemon.wait();
    assert!(ended.success(), "{ended}");
}

#[test]
fn reload_applies_or_keeps_the_configuration() {
    let bus = FreshBus::new("reload");
    let mut world = World::open(&bus);
    let mut daemon = Daemon::start_with(&bus, "", &[], |_| ());
    world.until("a robot that may move", |s| s.mode == Mode::READY);
    let get = |world: &mut World| world.control(ControlOp::PARAM_GET, "grasp.dr_n", 0.0).value;
    let write = |text: &str| fs::write(daemon.config_file(), text).expect("writable");

    write("grasp.dr_n = 0.1");
    daemon.signal(Signal::HUP);
    wait_for("the new value", || (get(&mut world) == 0.1).then_some(()));

    let mut check_refused = |text: &str, message: &str| {
        write(text);
        let reply = world.control(ControlOp::RELOAD, "", 0.0);
        assert_eq!(reply.outcome, ControlOutcome::REFUSED);
        assert!(reply.text.as_str().contains(message), "{}", reply.text);
        assert_eq!(get(&mut world), 0.1, "nothing changed");
    };
    check_refused(
        "grasp.dr_n = 0.2\nrealtime.rate_hz = 500",
        "could not change realtime.rate_hz while running",
    );
    check_refused("grasp.dr_n = 0.2\ngrasp.slip_on = 9", "grasp.slip_on is 9");
    // Regression: the file could change a safety value of a moving robot.
    check_refused(
        "grasp.dr_n = 0.2\nsafety.grip_ceiling_n = 21.0",
        "needs a stopped robot",
    );

    write("grasp.dr_n = 0.3");
    assert_eq!(
        world.control(ControlOp::RELOAD, "", 0.0).outcome,
        ControlOutcome::DONE
    );
    assert_eq!(get(&mut world), 0.3);
    assert!(daemon.is_running());
}
