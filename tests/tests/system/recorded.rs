//! A grasp in lock-step, recorded with its frames.

use std::path::Path;
use std::process::Command;

use rustix::process::Signal;
use shm_bus::FreshBus;
use system_tests::{Process, binary, wait_for};

/// Exit codes and the recorder's log.
pub(crate) struct Recorded {
    pub(crate) goal: Option<i32>,
    recorder: Option<i32>,
    log: String,
}

/// Records a grasp with the right hand without data loss; returns the goal's exit code.
pub(crate) fn grasp(object: &str, file: &str) -> Option<i32> {
    let recorded = record(object, file);
    assert_eq!(recorded.recorder, Some(0), "{}", recorded.log);
    recorded.goal
}

/// Records a grasp with the right hand; data loss is permitted.
pub(crate) fn record(object: &str, file: &str) -> Recorded {
    let bus = FreshBus::new("recorded");
    let name = bus.as_str();
    let mut recorder = Process::start("atas", &["record", "--bus", name, "--out", file]);
    wait_for("the recorder", || Path::new(file).exists().then_some(()));
    let simulate = ["run", "--lockstep", "--object", object, "--bus", name];
    let _robot = Process::start("atas-sim", &simulate);
    let control = [
        "--lockstep",
        "--record-stream",
        "--config",
        "/dev/null",
        "--bus",
        name,
    ];
    let mut daemon = Process::start("atasd", &control);
    wait_for("the daemon", || {
        let asked = Command::new(binary("atas"))
            .args(["status", "--bus", name])
            .output();
        asked
            .is_ok_and(|output| output.status.success())
            .then_some(())
    });
    let goal = "grasp --at 0.32,-0.15,0.0345 --width 50 --lift 10 --hold 0.05 --bus";
    let goal: Vec<&str> = goal.split(' ').chain([name]).collect();
    let goal = Process::start("atas", &goal).wait().code();
    daemon.signal(Signal::TERM);
    daemon.wait();
    recorder.signal(Signal::INT);
    Recorded {
        goal,
        recorder: recorder.wait().code(),
        log: recorder.log(),
    }
}
