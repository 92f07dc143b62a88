//! A daemon that stands still is told by its name, and a stop that no tick took is not called one.

use rustix::process::Signal;
use shm_bus::{Bus, FreshBus, Realtime};
use shm_schemas::{Mode, Status, service};
use system_tests::{Process, alone, in_virtual_time, wait_for};

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

    /// How a command ends, and what it says.
    fn atas(&self, word: &str) -> (i32, String) {
        let mut asked = Process::start("atas", &[word, "--bus", self.bus.as_str()]);
        let code = asked.wait().code().expect("no signal");
        (code, asked.log())
    }

    fn check(&self, word: &str, code: i32, parts: &[&str]) {
        let (ended, said) = self.atas(word);
        assert_eq!(ended, code, "atas {word}: {said}");
        for part in parts {
            assert!(said.contains(part), "atas {word}: {said}");
        }
    }

    /// The stop that was asked for meanwhile counts.
    fn until_stopped(&self) {
        let observer = Bus::open(&self.bus, "observer", Realtime::No).expect("a bus");
        let statuses = observer.subscriber::<Status>(service::STATUS);
        let (mut statuses, mut status) = (statuses.expect("a subscriber"), Status::default());
        wait_for("the stop", || {
            statuses.newest(&mut status).expect("readable");
            (status.mode == Mode::SAFE_STOP).then_some(())
        });
    }
}

#[test]
fn a_stopped_process_is_told_by_name_and_takes_the_stop_when_it_goes_on() {
    let _alone = alone();
    let rig = Rig::new(&[]);
    rig.daemon.signal(Signal::STOP);
    let owner = format!("atasd (process {}), which owns the bus", rig.daemon.pid());
    rig.check("status", 3, &[&owner, "is stopped", "kill -CONT"]);
    rig.check(
        "estop",
        3,
        &[&owner, "is stopped", "counts when it goes on"],
    );
    rig.daemon.signal(Signal::CONT);
    rig.until_stopped();
    rig.check("estop", 0, &["stopped; `atas recover` re-arms"]);
}

#[test]
fn a_stop_that_no_tick_took_is_a_failure() {
    let _shared = in_virtual_time();
    let rig = Rig::new(&["--lockstep"]);
    rig.robot.signal(Signal::STOP);
    // The frame that was on its way has its tick yet. No frame, no tick.
    rig.atas("estop");
    let process = format!("process {}", rig.daemon.pid());
    rig.check("estop", 1, &["no tick took it within 1s", &process]);
    rig.robot.signal(Signal::CONT);
    rig.until_stopped();
    rig.check("estop", 0, &["stopped; `atas recover` re-arms"]);
}
