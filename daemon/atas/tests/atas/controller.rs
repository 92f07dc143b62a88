//! Whole controller: modes, goals and client updates.

use crate::support::JOINTS;
use crate::support::home;
use crate::world::{World, commanded_gap_m, grasp, start};
use atas_core::OperatorRequest;
use shm_schemas::{
    Cause, EventKind, GoalKind, GoalPolicy, GoalRequest, GoalState, Hand, Mode, ModuleEvent, Reason,
};

fn kinds(events: &[ModuleEvent], kind: EventKind) -> usize {
    events.iter().filter(|e| e.kind == kind).count()
}

#[test]
fn init_becomes_ready_with_valid_inputs() {
    let mut world = World::new();
    let first = world.tick();
    assert_eq!(
        (first.command.mode, first.command.joint_count),
        (Mode::INIT, 0)
    );
    let (outputs, ticks) = world.run_until(100, |w| w.mode() != Mode::INIT);
    assert_eq!(
        (outputs.command.mode, outputs.command.joint_count, ticks),
        (Mode::READY, 22, 19)
    );
    assert_eq!(outputs.command.position[..JOINTS], *home());
    assert_eq!(kinds(outputs.events.as_slice(), EventKind::MODE), 1);
    for _ in 0..100 {
        let outputs = world.tick();
        assert_eq!(outputs.command.position[..JOINTS], *home());
        assert!(outputs.command.is_intact());
        assert_eq!(outputs.report.command_crc32, outputs.command.crc32);
    }
}

#[test]
fn init_reports_the_missing_input() {
    let no_frames_of = |hand| Reason::FramesStopped {
        hand,
        age_ns: None,
        limit_ns: 5e6,
    };
    let no_joints = Reason::JointsStopped {
        age_ns: None,
        limit_ns: 5e6,
    };
    for (mute, expected) in [
        ([true, false, false], no_frames_of(Hand::LEFT)),
        ([false, true, false], no_frames_of(Hand::RIGHT)),
        ([false, false, true], no_joints),
    ] {
        let mut world = World::new();
        world.silent = mute;
        let outputs = world.run(200);
        assert_eq!(world.controller.mode(), (Mode::INIT, expected));
        assert_eq!(
            (outputs.command.joint_count, outputs.command.mode),
            (0, Mode::INIT)
        );
        world.silent = [false; 3];
        world.run(30);
        assert_eq!(world.mode(), Mode::READY);
    }
}

#[test]
fn unstartable_goals_are_rejected_with_reason() {
    let rejected = |world: &mut World, goal: GoalRequest| {
        let outputs = world.request(start(goal));
        let update = outputs.goal_update.expect("update in the same tick");
        assert_eq!(
            (update.state, update.goal_id),
            (GoalState::REJECTED, goal.goal_id)
        );
        update.reason.cause
    };
    assert_eq!(rejected(&mut World::new(), grasp()), Cause::NOT_READY);
    let mut stopped = World::ready();
    stopped.request(OperatorRequest::Stop(Reason::Estop));
    assert_eq!(rejected(&mut stopped, grasp()), Cause::NOT_READY);
    let mut reaching = World::reaching();
    assert_eq!(
        rejected(
            &mut reaching,
            GoalRequest {
                goal_id: 8,
                ..grasp()
            }
        ),
        Cause::BUSY
    );
    assert_eq!(
        reaching.controller.goal().unwrap().request.goal_id,
        7,
        "the first goal continues"
    );
    assert_eq!(
        rejected(
            &mut World::holding(),
            GoalRequest {
                goal_id: 8,
                ..grasp()
            }
        ),
        Cause::HAND_FULL
    );
}

#[test]
fn grasp_reports_its_steps_in_order() {
    let mut world = World::ready();
    world.has_object = true;
    let mut updates = vec![world.request(start(grasp())).goal_update.unwrap()];
    let (mut steps, mut sequence) = (Vec::<String>::new(), None);
    while !updates.last().unwrap().state.is_final() {
        let outputs = world.tick();
        updates.extend(outputs.goal_update);
        for event in outputs.events.as_slice() {
            assert!(
                sequence.is_none_or(|s| event.stamp.sequence == s + 1),
                "no event is lost"
            );
            sequence = Some(event.stamp.sequence);
            if event.kind == EventKind::STEP {
                steps.push(event.text.to_string());
            }
        }
        assert!(
            world.ms < 100_000,
            "in step {}",
            world.controller.step_name()
        );
    }
    let states: Vec<_> = updates.iter().map(|u| u.state).collect();
    assert_eq!(states[0], GoalState::ACCEPTED);
    assert!(
        states[1..states.len() - 1]
            .iter()
            .all(|s| *s == GoalState::RUNNING)
    );
    assert_eq!(*states.last().unwrap(), GoalState::SUCCEEDED);
    assert_eq!(
        steps,
        ["descend", "approach", "probe", "grip", "lift", "hold"]
    );
    assert!(updates.is_sorted_by(|a, b| a.progress <= b.progress));
    let last = updates.last().unwrap();
    assert_eq!(last.progress, 1.0);
    let figures = last.figures;
    assert!(
        figures.f1_n > 0.0 && figures.f2_n > figures.f1_n && figures.stiffness_n_m > 0.0,
        "{figures:?}"
    );
    assert!((figures.lifted_m - 0.03).abs() < 1e-3, "{figures:?}");
    assert!(
        figures.normal_n[..2]
            .iter()
            .all(|n| *n > figures.f1_n * 0.9 && *n < figures.f2_n * 1.2),
        "{figures:?}"
    );
}

#[test]
fn report_contains_the_closing_speed() {
    let mut world = World::ready();
    world.has_object = true;
    world.request(start(grasp()));
    world.run_until(30_000, |w| w.controller.step_name() == "approach");
    let report = world.run(40).report;
    assert!(
        (report.hands[1].fingers[0].closing_m_s - 0.002).abs() < 1e-6,
        "{:?}",
        report.hands[1].fingers[0]
    );
    assert_eq!(report.hands[0].fingers[0].closing_m_s, 0.0);
}

/// The hand must not push over an obstacle: it goes back and reports the touch.
#[test]
fn touch_on_the_way_triggers_return() {
    let mut world = World::ready();
    let home = world.run(1).report.hands[1].centre_m;
    world.request(start(grasp()));
    world.run(400);
    let met = world.run(1).report.hands[1].centre_m;
    world.obstructed = true;
    let (_, ticks) = world.run_until(50, |w| w.controller.step_name() == "withdraw");
    assert!(ticks < 20, "{ticks} ticks");
    world.obstructed = false;
    let (outputs, _) = world.run_until(20_000, |w| w.controller.goal().unwrap().state.is_final());
    let update = outputs.goal_update.unwrap();
    let reason = Reason::from(update.reason);
    assert_eq!(update.state, GoalState::REFUSED, "{reason:?}");
    assert!(
        matches!(reason, Reason::Obstructed { fingertip: 1, .. }),
        "{reason:?}"
    );
    let far_mm = |a: [f64; 3], b: [f64; 3]| {
        let squares: f64 = a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum();
        squares.sqrt() * 1e3
    };
    let back = world.run(300).report.hands[1].centre_m;
    assert!(
        far_mm(home, met) > 5.0 && far_mm(home, back) < 2.0,
        "{home:?} {met:?} {back:?}"
    );
}

#[test]
fn missing_object_is_reported_and_hand_stays() {
    let mut world = World::ready();
    world.request(start(grasp()));
    let (outputs, _) = world.run_until(60_000, |w| w.controller.goal().unwrap().state.is_final());
    let update = outputs.goal_update.unwrap();
    assert_eq!(
        (update.state, update.reason.cause),
        (GoalState::FAILED, Cause::NOTHING_TOUCHED)
    );
    let rest = world.run(200).command.position;
    assert_eq!(world.run(100).command.position, rest);
    assert_eq!(world.mode(), Mode::READY);
}

/// The fingertips must not mistake each other for the missing narrow object.
#[test]
fn narrow_object_search_stops_before_fingertips_meet() {
    let mut world = World::ready();
    world.request(start(GoalRequest {
        width_m: 0.02,
        ..grasp()
    }));
    let (outputs, _) = world.run_until(60_000, |w| w.controller.goal().unwrap().state.is_final());
    let reason = outputs.goal_update.unwrap().reason;
    let Reason::NothingTouched { width_m, .. } = Reason::from(reason) else {
        panic!("{reason}")
    };
    assert!(width_m > 0.0019 && width_m < 0.002, "{reason}");
}

#[test]
fn cancel_stops_the_hand_in_place() {
    let mut world = World::reaching();
    assert!(
        world
            .request(OperatorRequest::Cancel { goal_id: 99 })
            .goal_update
            .is_none(),
        "other goal"
    );
    let update = world
        .request(OperatorRequest::Cancel { goal_id: 7 })
        .goal_update
        .unwrap();
    assert_eq!(
        (update.state, update.reason.cause),
        (GoalState::CANCELLED, Cause::CANCELLED)
    );
    let rest = world.run(300).command.position;
    assert_eq!(
        (world.mode(), world.run(100).command.position),
        (Mode::READY, rest)
    );
    assert_eq!(
        world.request(start(grasp())).goal_update.unwrap().state,
        GoalState::ACCEPTED
    );
}

#[test]
fn cancel_keeps_the_grip() {
    let mut world = World::ready();
    world.has_object = true;
    world.request(start(grasp()));
    world.run_until(30_000, |w| w.controller.step_name() == "lift");
    world.run(500);
    let gap_m = commanded_gap_m(&world.request(OperatorRequest::Cancel { goal_id: 7 }));
    let outputs = world.run(2000);
    assert_eq!(
        (world.mode(), world.controller.step_name()),
        (Mode::RUN, "hold")
    );
    assert!((commanded_gap_m(&outputs) - gap_m).abs() < 1e-3);
    assert!(
        outputs.report.hands[1].fingers[..2]
            .iter()
            .all(|f| f.in_contact == 1)
    );
    let release = GoalRequest {
        goal_id: 9,
        kind: GoalKind::RELEASE,
        ..grasp()
    };
    assert_eq!(
        world.request(start(release)).goal_update.unwrap().state,
        GoalState::ACCEPTED
    );
    let (outputs, _) = world.run_until(30_000, |w| w.controller.step_name() == "leave");
    assert!(commanded_gap_m(&outputs) > gap_m + 0.01);
    let (outputs, _) = world.run_until(30_000, |w| w.controller.goal().unwrap().state.is_final());
    assert_eq!(outputs.goal_update.unwrap().state, GoalState::SUCCEEDED);
}

#[test]
fn disconnect_ends_only_attached_goals() {
    for (policy, expected) in [
        (GoalPolicy::DETACHED, None),
        (
            GoalPolicy::ATTACHED,
            Some((GoalState::FAILED, Cause::CLIENT_GONE)),
        ),
    ] {
        let mut world = World::ready();
        world.request(start(GoalRequest { policy, ..grasp() }));
        world.run(20);
        let update = world
            .request(OperatorRequest::ClientDisconnected { goal_id: 7 })
            .goal_update;
        assert_eq!(update.map(|u| (u.state, u.reason.cause)), expected);
    }
}

#[test]
fn valid_parameters_apply_and_invalid_do_not() {
    let mut world = World::ready();
    let index = atas_core::settings::PARAMETERS
        .iter()
        .position(|p| p.name == "motion.reach_m_s")
        .unwrap();
    for (value, kept) in [(0.2, 0.2), (f64::NAN, 0.2), (1e9, 0.2), (0.05, 0.05)] {
        world.request(OperatorRequest::SetParameter { index, value });
        assert_eq!(world.controller.settings().motion.reach_m_s, kept);
    }
    world.request(OperatorRequest::SetParameter {
        index: usize::MAX,
        value: 0.1,
    });
    world.request(OperatorRequest::Bias { hand: usize::MAX });
    assert_eq!(world.mode(), Mode::READY);
}

#[test]
fn bias_zeroes_the_present_reading() {
    let mut world = World::ready();
    world.obstructed = true;
    let before = world.run(100).report.hands[1].fingers[1];
    assert!(before.normal_n > 0.4, "{before:?}");
    world.request(OperatorRequest::Bias { hand: 1 });
    let after = world.tick().report.hands[1].fingers[1];
    assert!(after.normal_n.abs() < 0.05, "{after:?}");
}

#[test]
fn grip_continues_after_success() {
    let mut world = World::holding();
    let outputs = world.run(3000);
    assert_eq!(
        (world.mode(), world.controller.step_name()),
        (Mode::RUN, "hold")
    );
    assert!(
        outputs.report.hands[1].fingers[..2]
            .iter()
            .all(|f| f.normal_n > 0.2)
    );
    assert_eq!(outputs.report.goal_id, 0, "the goal has ended");
}

/// A controller is large, and its user seldom chooses the stack size.
#[test]
fn controller_fits_half_the_default_stack() {
    const HALF_BYTES: usize = 1 << 20;
    let thread = std::thread::Builder::new().stack_size(HALF_BYTES);
    let reached = thread.spawn(|| World::new().clone().run(50).command.mode);
    assert_eq!(reached.unwrap().join().unwrap(), Mode::READY);
}
