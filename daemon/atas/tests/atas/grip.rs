//! Grip persistence across stops, and requests that are rejected while the robot works.

use crate::support::JOINTS;
use crate::world::{World, commanded_gap_m, grasp, start};
use atas_core::settings::PARAMETERS;
use atas_core::{Inputs, OperatorRequest, Tick};
use shm_schemas::{Cause, EventKind, GoalState, Hand, Mode, Reason};

fn warned(outputs: &atas_core::Outputs) -> Vec<Cause> {
    let events = outputs.events.as_slice().iter();
    let warnings = events.filter(|event| event.kind == EventKind::WARNING);
    warnings.map(|event| event.reason.cause).collect()
}

/// Regression: stop and recovery restarted from measured positions and lost the grip.
#[test]
fn grip_is_kept_through_stop_and_recovery() {
    let mut world = World::holding();
    let held = world.run(1).command.position;
    world.request(OperatorRequest::Stop(Reason::Estop));
    world.run(100);
    // Servos under load deviate slightly from their commands.
    for q in world.q.iter_mut() {
        *q += 0.004;
    }
    world.request(OperatorRequest::Recover);
    let (outputs, _) = world.run_until(100, |w| w.controller.step_name() == "keep grip");
    assert_eq!(warned(&outputs), [Cause::GRIP_FOUND]);
    let found = outputs.events.as_slice().iter();
    let mut found = found.filter(|event| event.reason.cause == Cause::GRIP_FOUND);
    assert!(found.all(|event| event.hand == Hand::RIGHT));
    assert_eq!(world.run(1).command.mode, Mode::RUN);
    let off_rad = |at: &[f64]| {
        let pairs = held[..JOINTS].iter().zip(at);
        pairs.fold(0.0, |most: f64, (a, b)| most.max((a - b).abs()))
    };
    assert!(off_rad(&outputs.command.position) < 1e-4);
    let refused = world.request(start(grasp())).goal_update.unwrap();
    assert_eq!(refused.reason.cause, Cause::HAND_FULL);
}

/// Regression: each daemon restart lost F_2 and then allowed a fifth more force.
#[test]
fn force_limit_survives_restarts_and_stops() {
    let mut world = World::holding();
    let borne_n = world.run(1).command.grip_limit_n;
    assert!(borne_n[0] == 0.0 && borne_n[1] > 0.0, "{borne_n:?}");
    for _ in 0..3 {
        world.restart();
        assert_eq!(world.controller.step_name(), "keep grip");
        assert_eq!(world.run(1).command.grip_limit_n, borne_n);
        world.request(OperatorRequest::Stop(Reason::Estop));
        world.run(100);
        world.request(OperatorRequest::Recover);
        world.run(100);
        assert_eq!(world.run(1).command.grip_limit_n, borne_n);
    }
    world.stored_f2_n = [0.0; 2];
    world.restart();
    let guessed_n = world.run(1).command.grip_limit_n;
    assert!(guessed_n[1] > 0.0 && guessed_n[1] < borne_n[1]);
    world.has_object = false;
    assert_eq!(
        world.run(300).command.grip_limit_n,
        [0.0; 2],
        "the hand is empty"
    );
}

/// Regression: a reading of 25 N on every element opened the fingers without a warning.
#[test]
fn impossible_force_holds_without_opening() {
    let mut world = World::holding();
    let before_m = commanded_gap_m(&world.run(1));
    world.frame_fault = Some(|frame| frame.force_n = [[[25.0, 0.0, 0.0]; 64]; 4]);
    let outputs = world.run(1);
    let (mode, reason) = world.controller.mode();
    assert_eq!(mode, Mode::HOLD);
    assert!(
        matches!(
            reason,
            Reason::ForceImplausible {
                hand: Hand::RIGHT,
                ..
            }
        ),
        "{reason:?}"
    );
    let opened_m = commanded_gap_m(&outputs) - before_m;
    assert!(opened_m < 1e-5, "opened by {opened_m} m");
    let after_m = commanded_gap_m(&world.run(500));
    assert!(after_m - before_m < 1e-5);
    assert_eq!(world.mode(), Mode::HOLD);
}

/// Regression: after a stall of seconds the goal continued within 22 ms.
#[test]
fn loop_stall_fails_the_goal() {
    let mut world = World::reaching();
    world.ms += 5_000;
    let outputs = world.run(1);
    let update = outputs.goal_update.expect("goal update");
    assert_eq!(
        (update.state, update.reason.cause),
        (GoalState::FAILED, Cause::LOOP_STALLED)
    );
}

#[test]
fn bias_requires_an_empty_hand_at_rest() {
    let check = |world: &mut World, allowed: bool| {
        let outputs = world.request(OperatorRequest::Bias { hand: 1 });
        let refused = warned(&outputs).contains(&Cause::NOT_NOW);
        assert_eq!(!refused, allowed, "in {}", world.mode());
    };
    check(&mut World::ready(), true);
    check(&mut World::reaching(), false);
    check(&mut World::holding(), false);
    check(&mut World::new(), false);
}

#[test]
fn safety_limits_change_only_without_motion() {
    let index = |name: &str| PARAMETERS.iter().position(|p| p.name == name).unwrap();
    let set = |world: &mut World, name: &str, value: f64| {
        let index = index(name);
        world.request(OperatorRequest::SetParameter { index, value });
        (PARAMETERS[index].get)(world.controller.settings()) == value
    };
    let mut world = World::reaching();
    assert!(set(&mut world, "grasp.dr_n", 0.07));
    assert!(!set(&mut world, "safety.grip_ceiling_n", 30.0));
    world.request(OperatorRequest::Stop(Reason::Estop));
    assert!(set(&mut world, "safety.grip_ceiling_n", 30.0));
}

/// Regression: states of another robot process bypassed the jump check.
#[test]
fn restarted_robot_process_resets_the_position() {
    let mut world = World::reaching();
    world.silent[2] = true;
    world.run(25);
    world.silent[2] = false;
    world.joint_fault = Some(|state| state.stamp.writer_epoch += 1);
    let outputs = world.run(1);
    let update = outputs.goal_update.expect("goal update");
    assert_eq!(
        (update.state, update.reason.cause),
        (GoalState::FAILED, Cause::ROBOT_RESTARTED)
    );
    assert_eq!(
        outputs.command.joint_count, 0,
        "no command before the position is known"
    );
    let (outputs, _) = world.run_until(100, |w| w.mode() == Mode::READY);
    assert_eq!(outputs.command.position[..JOINTS], *world.q);
}

/// Regression: a joint state with the largest time stamp caused a panic in lock-step.
#[test]
fn largest_time_stamp_causes_no_panic() {
    let mut world = World::ready();
    let tick = Tick {
        index: u64::MAX,
        now_ns: u64::MAX,
    };
    let inputs = Inputs {
        tick,
        ..Inputs::default()
    };
    assert_eq!(
        world.controller.step(&inputs).command.valid_until_ns,
        u64::MAX
    );
}
