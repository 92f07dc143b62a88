//! Tests of a daemon that does not run: clients name its process, and a stop counts as confirmed
//! only after a tick.

use rustix::process::Signal;
use shm_bus::{Bus, FreshBus, Realtime};
use shm_schemas::{Mode, Status, service};
use system_tests::{Process, lock_exclusive, lock_shared, wait_for};

struct Rig {
    bus: FreshBus,
    robot: Process,
    daemon: Process,
}

impl Rig {
    fn new(more: &[&str]) -> Self {
        let bus = FreshBus::new("stopped");
        let on = ["--bus", bus.as_str()];
        let simulate = [&["run", "--object", "wood"], &on[..], more].concat();
        let control = [&["--config", "/dev/null"], &on[..], more].concat();
        let rig = Self {
            robot: Process::start("atas-sim", &simulate),
            daemon: Process::start("atasd", &control),
            bus,
        };
        wait_for("the daemon", || (rig.atas("status").0 == 0).then_some(()));
        rig
    }

    /// Runs a command; returns its exit code and output.
    fn atas(&self, word: &str) -> (i32, String) {
        let mut asked = Process::start("atas", &[word, "--bus", self.bus.as_str()]);
        let code = asked.wait().code().expect("no signal");
        (code, asked.log())
    }

    fn check(&self, word: &str, code: i32, parts: &[&str]) {
        let (ended, message) = self.atas(word);
        assert_eq!(ended, code, "atas {word}: {message}");
        for part in parts {
            assert!(message.contains(part), "atas {word}: {message}");
        }
    }

    /// Waits until the pending stop takes effect.
    fn wait_until_stopped(&self) {
        let observer = Bus::open(&self.bus, "observer", Realtime::No).expect("a bus");
        let statuses = observer.subscriber::<Status>(service::STATUS);
        let (mut statuses, mut status) = (statuses.expect("a subscriber"), Status::default());
        wait_for("the safe stop", || {
            statuses.newest(&mut status).expect("readable");
            (status.mode == Mode::SAFE_STOP).then_some(())
        });
    }
}

#[test]
fn suspended_daemon_is_named_and_stops_on_resume() {
    let _alone = lock_exclusive();
    let rig = Rig::new(&[]);
    rig.daemon.signal(Signal::STOP);
    let owner = format!("atasd (process {}), which owns the bus", rig.daemon.pid());
    rig.check("status", 3, &[&owner, "is stopped", "kill -CONT"]);
    rig.check(
        "estop",
        3,
        &[&owner, "is stopped", "takes effect when it continues"],
    );
    rig.daemon.signal(Signal::CONT);
    rig.wait_until_stopped();
    rig.check("estop", 0, &["stopped; `atas recover` re-arms"]);
}

#[test]
fn unconfirmed_stop_fails() {
    let _shared = lock_shared();
    let rig = Rig::new(&["--lockstep"]);
    rig.robot.signal(Signal::STOP);
    // A frame in transit may still cause one tick. Without frames, the lock-step daemon does not
    // tick.
    rig.atas("estop");
    let process = format!("process {}", rig.daemon.pid());
    rig.check("estop", 1, &["no tick took it within 1s", &process]);
    rig.robot.signal(Signal::CONT);
    rig.wait_until_stopped();
    rig.check("estop", 0, &["stopped; `atas recover` re-arms"]);
}
