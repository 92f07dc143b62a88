//! Faults against the whole controller, with the tick bounds of the fault catalogue.

use crate::support::JOINTS;
use crate::world::{World, commanded_gap_m};
use atas_core::{Inputs, OperatorRequest, Tick};
use shm_schemas::{Cause, GoalState, Mode, Reason};

/// F01, F40: silence of either sensor or of the joints.
#[test]
fn silence_holds_in_time_and_recovers() {
    for (mute, cause, bound) in [
        ([true, false, false], Cause::FRAMES_STOPPED, 6),
        ([false, true, false], Cause::FRAMES_STOPPED, 6),
        ([false, false, true], Cause::JOINTS_STOPPED, 6),
    ] {
        let mut world = World::reaching();
        world.silent = mute;
        let (_, ticks) = world.run_until(50, |w| w.mode() == Mode::HOLD);
        // The last message is one tick old when the silence shows: five more ticks make six.
        assert_eq!(ticks, bound, "{cause}");
        assert_eq!(world.controller.mode().1.cause(), cause);
        let rest = world.run(150).command.position;
        assert_eq!(world.run(50).command.position, rest, "HOLD keeps still");
        world.silent = [false; 3];
        let (_, ticks) = world.run_until(100, |w| w.mode() == Mode::RUN);
        assert!(ticks <= 50, "re-armed after {ticks} ticks");
        assert_eq!(world.controller.goal().unwrap().state, GoalState::RUNNING);
        world.run_until(20_000, |w| w.controller.step_name() == "approach");
    }
}

#[test]
fn grip_is_kept_during_silence() {
    let mut world = World::holding();
    let gap_m = commanded_gap_m(&world.tick());
    world.silent = [false, true, false];
    for _ in 0..3000 {
        let outputs = world.tick();
        assert!(commanded_gap_m(&outputs) < gap_m + 1e-4);
    }
    assert_eq!(world.mode(), Mode::HOLD);
    world.silent = [false; 3];
    world.run(100);
    assert_eq!(
        (world.mode(), world.controller.step_name()),
        (Mode::RUN, "hold")
    );
}

#[test]
fn long_pause_fails_the_goal() {
    let mut world = World::reaching();
    world.silent = [false, true, false];
    let (outputs, ticks) = world.run_until(2000, |w| w.controller.goal().unwrap().state.is_final());
    let update = outputs.goal_update.unwrap();
    assert_eq!(
        (update.state, update.reason.cause),
        (GoalState::FAILED, Cause::FRAMES_STOPPED)
    );
    assert!(
        (500..520).contains(&ticks),
        "safety.pause_s is 0.5 s, failed after {ticks} ticks"
    );
    world.silent = [false; 3];
    let rest = world.run(100).command.position;
    assert_eq!(
        (world.mode(), world.run(100).command.position),
        (Mode::READY, rest),
        "nothing resumes"
    );
}

/// F41.
#[test]
fn invalid_joint_feedback_stops_and_latches() {
    for fault in [
        (|s| s.position[3] = f64::NAN) as fn(&mut shm_schemas::JointState),
        |s| s.position[20] += 0.2,
        |s| s.position[0] = 1e12,
        |s| s.joint_count = 0,
    ] {
        let mut world = World::reaching();
        world.joint_fault = Some(fault);
        let outputs = world.tick();
        assert_eq!(outputs.command.mode, Mode::SAFE_STOP);
        let update = outputs.goal_update.unwrap();
        assert_eq!(
            (update.state, update.reason.cause),
            (GoalState::FAILED, Cause::JOINTS_INVALID)
        );
        world.joint_fault = None;
        let rest = world.run(300).command.position;
        assert_eq!(
            (world.mode(), world.run(100).command.position),
            (Mode::SAFE_STOP, rest),
            "latched"
        );
        world.request(OperatorRequest::Recover);
        assert_eq!(world.mode(), Mode::HOLD);
        world.run(30);
        assert_eq!(world.mode(), Mode::READY);
    }
}

/// F44.
#[test]
fn following_error_stops_the_robot() {
    let mut world = World::reaching();
    let stuck_rad = world.q;
    for ticks in 0.. {
        world.q = stuck_rad;
        if world.tick().command.mode == Mode::SAFE_STOP {
            break;
        }
        assert!(ticks < 1000);
    }
    assert_eq!(world.controller.mode().1.cause(), Cause::FOLLOWING_ERROR);
    world.q = stuck_rad;
    let mut outputs = world.request(OperatorRequest::Recover);
    for _ in 0..100 {
        world.q = stuck_rad;
        outputs = world.tick();
    }
    assert_eq!(world.mode(), Mode::READY);
    // A limb that did not track its command restarts from its measured position; a limb that nearly
    // did keeps its command.
    let off_rad = |i: usize| (outputs.command.position[i] - stuck_rad[i]).abs();
    assert!((0..JOINTS).all(|i| off_rad(i) <= atas_core::limits::PRELOAD_MAX_RAD));
    assert!((0..JOINTS).any(|i| off_rad(i) == 0.0));
}

#[test]
fn estop_latches_until_recovery() {
    let mut world = World::reaching();
    let outputs = world.request(OperatorRequest::Stop(Reason::Estop));
    assert_eq!(outputs.command.mode, Mode::SAFE_STOP);
    assert_eq!(outputs.goal_update.unwrap().reason.cause, Cause::ESTOP);
    let rest = world.run(1000).command.position;
    assert_eq!(
        (world.mode(), world.run(1).command.position),
        (Mode::SAFE_STOP, rest)
    );
    world.request(OperatorRequest::Recover);
    world.run(30);
    assert_eq!(world.mode(), Mode::READY);
}

/// Outside SAFE_STOP, recovery must release neither grip nor goal.
#[test]
fn recover_outside_safe_stop_has_no_effect() {
    let mut reaching = World::reaching();
    reaching.request(OperatorRequest::Recover);
    reaching.run_until(20_000, |w| w.controller.step_name() == "descend");
    let mut holding = World::holding();
    holding.request(OperatorRequest::Recover);
    holding.run(100);
    assert_eq!(
        (holding.mode(), holding.controller.step_name()),
        (Mode::RUN, "hold")
    );
    let mut silent = World::holding();
    silent.silent = [false, true, false];
    silent.run(50);
    silent.request(OperatorRequest::Recover);
    assert_eq!(silent.mode(), Mode::HOLD, "the hold reason persists");
}

/// F23, F24: after a stall the first tick holds, and missed motion is not made up.
#[test]
fn stall_holds_and_motion_is_not_made_up() {
    let mut world = World::reaching();
    let before = world.tick().command.position;
    world.ms += 300;
    let outputs = world.tick();
    assert_eq!(outputs.command.mode, Mode::HOLD);
    let moved = (0..JOINTS)
        .map(|i| (outputs.command.position[i] - before[i]).abs())
        .fold(0.0, f64::max);
    assert!(moved < 6e-3, "one tick at most: {moved} rad");
    world.run_until(100, |w| w.mode() == Mode::RUN);
}

/// The newest of several frames in one tick counts.
#[test]
fn frame_bursts_are_processed_in_order() {
    let mut world = World::ready();
    let mut sequence = world.ms;
    for burst in [0, 5, 1, 0, 0, 3, 2] {
        world.ms += 1;
        let now_ns = world.ms * crate::support::MS_NS;
        let frames: [Vec<_>; 2] = [shm_schemas::Hand::LEFT, shm_schemas::Hand::RIGHT].map(|hand| {
            (1..=burst)
                .map(|i| crate::support::frame(hand, sequence + i, now_ns - (burst - i) * 100_000))
                .collect()
        });
        sequence += burst;
        let state = crate::support::joints(world.ms, now_ns, &world.q);
        let outputs = world.controller.step(&Inputs {
            tick: Tick {
                index: world.ms,
                now_ns,
            },
            frames: [&frames[0], &frames[1]],
            joints: Some(&state),
            targets: &[],
            request: None,
        });
        let report = &outputs.report.hands[0];
        assert_eq!(
            (u64::from(report.frames), report.frame_sequence),
            (burst, sequence)
        );
    }
    assert_eq!(world.mode(), Mode::READY);
}
