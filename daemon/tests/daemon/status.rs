//! Status of the daemon: its clock, and operation without a robot.

use shm_bus::FreshBus;
use shm_schemas::{Cause, ControlOp, ControlOutcome, GoalState, Mode, StatusFlags};

use crate::goals::{LockStep, grasp};
use crate::support::{Daemon, TOLERANT, World, wait_for};

const SENSE_ONLY: &str = "robot.joints_required = false\n";

#[test]
fn start_time_uses_the_clock_of_stamps() {
    let bus = FreshBus::new("clock");
    let mut world = World::open(&bus);
    let begun_ns = shm_bus::now_ns();
    let real = Daemon::start_with(&bus, TOLERANT, &[], |_| ());
    let status = world.until_mode(Mode::READY);
    assert!((begun_ns..status.stamp.captured_ns).contains(&status.started_ns));
    drop((real, world));

    let bus = FreshBus::new("clock");
    let mut world = LockStep::open(&bus);
    let _virtual = Daemon::start(&bus, &["--lockstep"]);
    world.until("a tick", |status| status.ticks > 50);
    let status = world.world.newest;
    let period_ns = 1_000_000;
    assert_eq!(status.started_ns, period_ns, "the first tick's time");
    let up_ns = status.stamp.captured_ns - status.started_ns;
    assert_eq!(up_ns, (status.ticks - 1) * period_ns);
}

#[test]
fn sense_only_daemon_reports_its_reason() {
    let bus = FreshBus::new("senses");
    let mut world = World::open(&bus);
    world.sends_frames = false;
    let config = format!("{TOLERANT}{SENSE_ONLY}");
    let _daemon = Daemon::start_with(&bus, &config, &[], |_| ());
    let is_sense_only = |flags: u32| flags & StatusFlags::SENSE_ONLY != 0;
    let blind = world.until("a status", |status| status.ticks > 0);
    assert!(is_sense_only(blind.flags), "{blind:?}");
    assert_eq!(blind.reason.cause, Cause::FRAMES_STOPPED);
    world.sends_frames = true;
    world.until("frames", |status| status.reason.cause == Cause::SENSE_ONLY);

    let goals = world.bus.goal_client().expect("there is room");
    let mut pending = wait_for("the goal server", || goals.send(&grasp(1)).ok());
    let update = wait_for("an answer", || {
        world.publish(shm_bus::now_ns());
        pending.next().expect("the daemon lives")
    });
    let answer = (update.goal_id, update.state, update.reason.cause);
    assert_eq!(answer, (1, GoalState::REJECTED, Cause::SENSE_ONLY));
    let zero = world.control(ControlOp::BIAS, "", 0.0);
    assert_eq!(zero.outcome, ControlOutcome::REFUSED);
    let output = zero.text.as_str();
    assert!(
        output.contains("robot.joints_required is false"),
        "{output}"
    );
    assert!(
        output.ends_with("with --zero"),
        "the text is not truncated: {output}"
    );
}
