//! Grip persistence across stops, and requests that are rejected while the robot works.

use crate::support::JOINTS;
use crate::world::{World, commanded_gap_m, grasp, start};
use atas_core::settings::PARAMETERS;
use atas_core::{Inputs, Order, Tick};
use shm_schemas::{Cause, EventKind, GoalState, Hand, Mode, Reason};

fn warned(outputs: &atas_core::Outputs) -> Vec<Cause> {
    let events = outputs.events.as_slice().iter();
    let warnings = events.filter(|event| event.kind == EventKind::WARNING);
    warnings.map(|event| event.reason.cause).collect()
}

/// Regression: stop and recovery restarted from measured positions and lost the grip.
#[test]
fn a_stop_and_a_recover_keep_the_grip_and_watch_it() {
    let mut world = World::holding();
    let held_rad = world.run(1).command.position_rad;
    world.order(Order::Stop(Reason::of(Cause::ESTOP)));
    world.run(100);
    // Servos under load deviate slightly from their commands.
    for q_rad in world.q_rad.iter_mut() {
        *q_rad += 0.004;
    }
    world.order(Order::Recover);
    let (outputs, _) = world.run_until(100, |w| w.controller.step_name() == "keep grip");
    assert_eq!(warned(&outputs), [Cause::GRIP_FOUND]);
    let found = outputs.events.as_slice().iter();
    let mut found = found.filter(|event| event.reason.cause == Cause::GRIP_FOUND);
    assert!(found.all(|event| event.hand == Hand::RIGHT));
    assert_eq!(world.run(1).command.mode, Mode::RUN);
    let off_rad = |at: &[f64]| {
        let pairs = held_rad[..JOINTS].iter().zip(at);
        pairs.fold(0.0, |most: f64, (a, b)| most.max((a - b).abs()))
    };
    assert!(off_rad(&outputs.command.position_rad) < 1e-4);
    let refused = world.order(start(grasp())).goal_update.unwrap();
    assert_eq!(refused.reason.cause, Cause::HAND_FULL);
}

/// Regression: each daemon restart lost F_2 and then allowed a fifth more force.
#[test]
fn what_the_object_bears_is_known_after_restarts_and_stops() {
    let mut world = World::holding();
    let borne_n = world.run(1).command.grip_limit_n;
    assert!(borne_n[0] == 0.0 && borne_n[1] > 0.0, "{borne_n:?}");
    for _ in 0..3 {
        world.restart();
        assert_eq!(world.controller.step_name(), "keep grip");
        assert_eq!(world.run(1).command.grip_limit_n, borne_n);
        world.order(Order::Stop(Reason::of(Cause::ESTOP)));
        world.run(100);
        world.order(Order::Recover);
        world.run(100);
        assert_eq!(world.run(1).command.grip_limit_n, borne_n);
    }
    world.told_f2_n = [0.0; 2];
    world.restart();
    let guessed_n = world.run(1).command.grip_limit_n;
    assert!(guessed_n[1] > 0.0 && guessed_n[1] < borne_n[1]);
    world.has_object = false;
    assert_eq!(
        world.run(300).command.grip_limit_n,
        [0.0; 2],
        "nothing is held"
    );
}

/// Regression: a reading of 25 N on every element opened the fingers without a warning.
#[test]
fn a_force_that_cannot_be_holds_and_opens_nothing() {
    let mut world = World::holding();
    let before_m = commanded_gap_m(&world.run(1));
    world.frame_fault = Some(|frame| frame.force_n = [[[25.0, 0.0, 0.0]; 64]; 4]);
    let outputs = world.run(1);
    let (mode, reason) = world.controller.mode();
    assert_eq!(
        (mode, reason.cause, reason.index),
        (Mode::HOLD, Cause::FORCE_IMPLAUSIBLE, 1)
    );
    let opened_m = commanded_gap_m(&outputs) - before_m;
    assert!(opened_m < 1e-5, "opened by {opened_m} m");
    let after_m = commanded_gap_m(&world.run(500));
    assert!(after_m - before_m < 1e-5);
    assert_eq!(world.mode(), Mode::HOLD);
}

/// Regression: after a stall of seconds the goal continued within 22 ms.
#[test]
fn a_goal_does_not_outlive_a_loop_that_stood_still() {
    let mut world = World::reaching();
    world.ms += 5_000;
    let outputs = world.run(1);
    let update = outputs.goal_update.expect("news");
    assert_eq!(
        (update.state, update.reason.cause),
        (GoalState::FAILED, Cause::LOOP_STALLED)
    );
}

#[test]
fn zero_is_taken_only_with_an_empty_hand_at_rest() {
    let check = |world: &mut World, allowed: bool| {
        let outputs = world.order(Order::Bias { hand: 1 });
        let refused = warned(&outputs).contains(&Cause::NOT_NOW);
        assert_eq!(!refused, allowed, "in {}", world.mode());
    };
    check(&mut World::ready(), true);
    check(&mut World::reaching(), false);
    check(&mut World::holding(), false);
    check(&mut World::new(), false);
}

#[test]
fn bounds_of_the_motion_change_only_while_it_stands() {
    let index = |name: &str| PARAMETERS.iter().position(|p| p.name == name).unwrap();
    let set = |world: &mut World, name: &str, value: f64| {
        let index = index(name);
        world.order(Order::SetParameter { index, value });
        (PARAMETERS[index].get)(world.controller.settings()) == value
    };
    let mut world = World::reaching();
    assert!(set(&mut world, "grasp.dr_n", 0.07));
    assert!(!set(&mut world, "safety.grip_ceiling_n", 30.0));
    world.order(Order::Stop(Reason::of(Cause::ESTOP)));
    assert!(set(&mut world, "safety.grip_ceiling_n", 30.0));
}

/// Regression: states of another robot process bypassed the jump check.
#[test]
fn another_robot_process_is_asked_anew_where_it_stands() {
    let mut world = World::reaching();
    world.mute[2] = true;
    world.run(25);
    world.mute[2] = false;
    world.joint_fault = Some(|state| state.stamp.writer_epoch += 1);
    let outputs = world.run(1);
    let update = outputs.goal_update.expect("news");
    assert_eq!(
        (update.state, update.reason.cause),
        (GoalState::FAILED, Cause::ROBOT_RESTARTED)
    );
    assert_eq!(
        outputs.command.joint_count, 0,
        "nothing is commanded blindly"
    );
    let (outputs, _) = world.run_until(100, |w| w.mode() == Mode::READY);
    assert_eq!(outputs.command.position_rad[..JOINTS], *world.q_rad);
}

/// Regression: a joint state with the largest time stamp caused a panic in lock-step.
#[test]
fn the_end_of_time_is_no_panic() {
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
