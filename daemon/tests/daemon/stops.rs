//! Stops over the stop socket reach the robot in every state of the bus.

use std::time::Duration;

use shm_bus::{BusError, FreshBus, stop};
use shm_schemas::{Cause, ControlOp, ControlOutcome, Mode, StopOutcome};

use crate::support::{Daemon, TOLERANT, World};

const WITHIN: Duration = Duration::from_secs(2);

#[test]
fn stop_is_in_effect_when_answered() {
    let bus = FreshBus::new("stops");
    let mut world = World::open(&bus);
    let daemon = Daemon::start_with(&bus, TOLERANT, &[], |_| ());
    for _ in 0..20 {
        world.until_mode(Mode::READY);
        let answer = stop::request(&bus, "a test", WITHIN).expect("answered");
        assert_eq!(
            (answer.outcome, answer.pid),
            (StopOutcome::STOPPED, daemon.pid())
        );
        world.receive();
        assert_eq!(world.newest.mode, Mode::SAFE_STOP, "readers see the stop");
        assert_eq!(world.until_mode(Mode::SAFE_STOP).reason.cause, Cause::ESTOP);
        let recovered = world.control(ControlOp::RECOVER, "", 0.0);
        assert_eq!(recovered.outcome, ControlOutcome::DONE);
    }
}

#[test]
fn stop_works_with_all_control_clients_taken() {
    let bus = FreshBus::new("crowded");
    let mut world = World::open(&bus);
    let _daemon = Daemon::start_with(&bus, TOLERANT, &[], |_| ());
    world.until_mode(Mode::READY);
    let clients: Vec<_> = std::iter::from_fn(|| world.bus.control_client().ok()).collect();
    assert!(clients.len() > 8 && world.bus.control_client().is_err());
    let answer = stop::request(&bus, "a test", WITHIN).expect("answered");
    assert_eq!(answer.outcome, StopOutcome::STOPPED);
    assert_eq!(world.until_mode(Mode::SAFE_STOP).reason.cause, Cause::ESTOP);
}

#[test]
fn stop_fails_at_once_without_daemon() {
    let bus = FreshBus::new("ended");
    let mut world = World::open(&bus);
    let daemon = Daemon::start_with(&bus, TOLERANT, &[], |_| ());
    world.until_mode(Mode::READY);
    drop(daemon);
    let nobody = stop::request(&bus, "a test", WITHIN).expect_err("no daemon");
    assert!(matches!(nobody, BusError::NoServer { .. }), "{nobody}");
}
