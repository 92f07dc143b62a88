//! A blocked or failing log output does not affect the robot.

use std::fs::OpenOptions;
use std::process::{Command, Stdio};

use rustix::process::Signal;
use shm_bus::FreshBus;
use shm_schemas::{ControlOp, ControlOutcome, Mode};

use crate::support::{Daemon, TOLERANT, World};

/// Number of requests, each with a log line: several times the capacity of a pipe.
const REQUESTS: usize = 2_000;

fn check(what: &str, stderr: impl FnOnce(&mut Command)) {
    let bus = FreshBus::new(what);
    let mut world = World::open(&bus);
    let more = |command: &mut Command| {
        command.env("RUST_LOG", "debug");
        stderr(command);
    };
    let mut daemon = Daemon::start_with(&bus, TOLERANT, &[], more);
    world.until_mode(Mode::READY);
    for _ in 0..REQUESTS {
        let reply = world.control(ControlOp::PARAM_GET, "grasp.dr_n", 0.0);
        assert_eq!(reply.outcome, ControlOutcome::DONE, "{what}");
    }
    world.until_mode(Mode::READY);
    let stopped = world.control(ControlOp::ESTOP, "", 0.0);
    assert_eq!(stopped.outcome, ControlOutcome::DONE, "{what}");
    world.until_mode(Mode::SAFE_STOP);
    daemon.signal(Signal::TERM);
    assert!(daemon.wait().success(), "{what}");
}

#[test]
fn unread_log_does_not_block_the_daemon() {
    // The pipe's other end stays open and is never read.
    check("unread", |command| {
        command.stderr(Stdio::piped());
    });
}

#[test]
fn full_disk_log_does_not_end_the_daemon() {
    check("full", |command| {
        let full = OpenOptions::new().write(true).open("/dev/full");
        command.stderr(full.expect("the kernel's full device"));
    });
}
