//! Goal validation: every invalid field has its cause and name.

use crate::support::{angular_jaw, robot};
use atas_core::check::{self, GoalContext};
use atas_core::goal::ActiveGoal;
use atas_core::tasks::{GRASP, RELEASE, Task};
use atas_core::{Goal, SensorSetup, Settings};
use robot_model::HandSide;
use shm_schemas::{
    Cause, GoalField, GoalKind, GoalPolicy, GoalRequest, Hand, Reason, ReasonRecord, Text,
};

pub(crate) fn goal() -> GoalRequest {
    GoalRequest {
        goal_id: 1,
        kind: GoalKind::GRASP,
        hand: Hand::RIGHT,
        policy: GoalPolicy::DETACHED,
        from_m: [0.3, -0.1, 0.05],
        width_m: 0.05,
        lift_m: 0.05,
        hold_s: 1.0,
        ..GoalRequest::default()
    }
}

fn check_with(goal: &GoalRequest, wiring: &SensorSetup, tasks: &[Task]) -> Result<Goal, Reason> {
    let now = GoalContext {
        robot: robot(),
        wiring,
        settings: &Settings::default(),
        tasks,
        commanded_position: None,
    };
    check::check(goal, &now)
}

fn check(goal: &GoalRequest, wiring: &SensorSetup) -> Result<HandSide, Reason> {
    check_with(goal, wiring, &[]).map(|goal| goal.side())
}

#[test]
fn valid_goal_resolves_its_hand() {
    assert_eq!(check(&goal(), &SensorSetup::default()), Ok(HandSide::Right));
    let left = GoalRequest {
        hand: Hand::LEFT,
        from_m: [0.3, 0.1, 0.05],
        ..goal()
    };
    assert_eq!(check(&left, &SensorSetup::default()), Ok(HandSide::Left));
    let attached = GoalRequest {
        policy: GoalPolicy::ATTACHED,
        ..goal()
    };
    let attached = Goal::resolve(&attached, &[]).unwrap();
    assert!(ActiveGoal::begin(&attached).is_attached());
    // A release needs no position.
    let release = GoalRequest {
        kind: GoalKind::RELEASE,
        from_m: [9.0; 3],
        width_m: 0.0,
        ..goal()
    };
    assert_eq!(
        check(&release, &SensorSetup::default()),
        Ok(HandSide::Right)
    );
}

#[test]
fn every_invalid_field_is_named() {
    type Change = fn(&mut GoalRequest);
    let rows: [(Change, Cause, u32); 32] = [
        (|g| g.kind = GoalKind(0), Cause::UNKNOWN_GOAL, 0),
        (|g| g.kind = GoalKind(u32::MAX), Cause::UNKNOWN_GOAL, 0),
        (|g| g.kind = GoalKind::CUSTOM, Cause::UNKNOWN_TASK, 0),
        (|g| g.hand = Hand(2), Cause::UNKNOWN_GOAL, 1),
        (|g| g.policy = GoalPolicy(2), Cause::UNKNOWN_GOAL, 2),
        (|g| g.from_m[0] = f64::NAN, Cause::NOT_FINITE, 0),
        (|g| g.from_m[2] = f64::INFINITY, Cause::NOT_FINITE, 2),
        (|g| g.to_m[1] = f64::NAN, Cause::NOT_FINITE, 5),
        (|g| g.to_yaw_rad = f64::NEG_INFINITY, Cause::NOT_FINITE, 7),
        (|g| g.hold_s = f64::INFINITY, Cause::NOT_FINITE, 10),
        (|g| g.from_yaw_rad = 7.0, Cause::OUT_OF_RANGE, 3),
        (|g| g.lift_m = -0.01, Cause::OUT_OF_RANGE, 9),
        (|g| g.lift_m = 0.151, Cause::OUT_OF_RANGE, 9),
        (|g| g.hold_s = -1.0, Cause::OUT_OF_RANGE, 10),
        (|g| g.hold_s = 3601.0, Cause::OUT_OF_RANGE, 10),
        (|g| g.from_m[0] = 0.1, Cause::UNREACHABLE, 0),
        (|g| g.from_m[0] = 1e300, Cause::UNREACHABLE, 0),
        (|g| g.from_m[1] = 0.2, Cause::UNREACHABLE, 1),
        (|g| g.from_m[1] = -0.4, Cause::UNREACHABLE, 1),
        (|g| g.from_m[2] = 0.0, Cause::UNREACHABLE, 2),
        (|g| g.from_m[2] = 0.3, Cause::UNREACHABLE, 2),
        (
            |g| (g.from_m[2], g.lift_m) = (0.15, 0.1),
            Cause::UNREACHABLE,
            9,
        ),
        (|g| g.width_m = 0.0, Cause::UNREACHABLE, 8),
        (|g| g.width_m = 0.2, Cause::UNREACHABLE, 8),
        (|g| g.top_m = f64::NAN, Cause::NOT_FINITE, 12),
        (|g| g.top_m = -0.01, Cause::OUT_OF_RANGE, 12),
        (|g| g.top_m = 0.6, Cause::OUT_OF_RANGE, 12),
        // Above the palm clearance.
        (|g| g.top_m = 0.3, Cause::OUT_OF_RANGE, 12),
        (|g| g.max_force_n = f64::NAN, Cause::NOT_FINITE, 13),
        (|g| g.max_force_n = -1.0, Cause::OUT_OF_RANGE, 13),
        (|g| g.max_force_n = 0.1, Cause::OUT_OF_RANGE, 13),
        (|g| g.max_force_n = 8.1, Cause::OUT_OF_RANGE, 13),
    ];
    for (change, cause, index) in rows {
        let mut goal = goal();
        change(&mut goal);
        let reason = check(&goal, &SensorSetup::default()).unwrap_err();
        let record = ReasonRecord::from(reason);
        assert_eq!((record.cause, record.index), (cause, index), "{goal:?}");
    }
}

/// A user task is found by its exact name and requires what its steps need.
#[test]
fn user_tasks_are_found_by_name() {
    let own = |name: &str, task: &Task| Task::validated(name, &task.acting, None).unwrap();
    let tasks = [own("hold-it", &GRASP), own("let-go", &RELEASE)];
    let ask = |name: &str, change: fn(&mut GoalRequest)| {
        let mut goal = GoalRequest {
            kind: GoalKind::CUSTOM,
            task: Text::new(name),
            ..goal()
        };
        change(&mut goal);
        check_with(&goal, &SensorSetup::default(), &tasks)
            .map(|goal| goal.task().name.to_string())
            .map_err(|reason| reason.cause())
    };
    assert_eq!(ask("let-go", |_| ()).as_deref(), Ok("let-go"));
    assert_eq!(ask("grasp", |_| ()).as_deref(), Ok("grasp"), "built in");
    for name in ["", "let", "let-go-", "custom", "Let-go"] {
        assert_eq!(ask(name, |_| ()), Err(Cause::UNKNOWN_TASK), "{name}");
    }
    let far: fn(&mut GoalRequest) = |g| g.from_m[0] = 9.0;
    assert_eq!(ask("let-go", far).as_deref(), Ok("let-go"));
    assert_eq!(ask("hold-it", far), Err(Cause::UNREACHABLE));
}

#[test]
fn hand_without_sensor_accepts_no_goals() {
    let mut wiring = SensorSetup::default();
    wiring.hands[1].required = false;
    let reason = check(&goal(), &wiring).unwrap_err();
    assert_eq!(reason, Reason::NoSensor { hand: Hand::RIGHT });
    let left = GoalRequest {
        hand: Hand::LEFT,
        from_m: [0.3, 0.1, 0.05],
        ..goal()
    };
    assert!(check(&left, &wiring).is_ok());
}

#[test]
fn hand_workspaces_mirror_each_other() {
    for y in [-0.35, -0.3, -0.1, 0.0, 0.06, 0.1] {
        let right = GoalRequest {
            from_m: [0.3, y, 0.05],
            ..goal()
        };
        let left = GoalRequest {
            hand: Hand::LEFT,
            from_m: [0.3, -y, 0.05],
            ..goal()
        };
        let reached = [right, left].map(|g| check(&g, &SensorSetup::default()).is_ok());
        assert_eq!(reached[0], reached[1], "y = {y}");
    }
}

/// 5-DOF arm with one fixed and one rotating jaw. The reason for an impossible yaw names the
/// nearest possible one; for an impossible width it names the misalignment of the fingertips.
#[test]
fn angular_jaw_rejects_impossible_yaw_and_width() {
    let robot = angular_jaw();
    let wiring = SensorSetup::from_robot(robot);
    let refused = |yaw_deg: f64, width_m: f64| {
        let goal = GoalRequest {
            from_m: [0.21, 0.0, 0.035],
            from_yaw_rad: yaw_deg.to_radians(),
            width_m,
            lift_m: 0.04,
            ..goal()
        };
        let now = GoalContext {
            robot,
            wiring: &wiring,
            settings: &Settings::default(),
            tasks: &[],
            commanded_position: None,
        };
        check::check(&goal, &now).err()
    };
    assert_eq!(refused(0.0, 0.05), None);
    assert_eq!(refused(180.0, 0.05), None);
    let yaw = refused(90.0, 0.05).expect("the hand tilts only in the plane of its arm");
    let Reason::Unreachable {
        field: GoalField::FROM_YAW,
        limit: nearest_rad,
        ..
    } = yaw
    else {
        panic!("{yaw:?}")
    };
    assert!(yaw.to_string().contains("from yaw is 90.0°"), "{yaw}");
    let nearest = refused(nearest_rad.to_degrees(), 0.05);
    assert_eq!(nearest, None, "{yaw}");
    let narrow = refused(0.0, 0.015).expect("too narrow");
    assert_eq!(narrow.cause(), Cause::FINGERTIPS_MISALIGNED, "{narrow}");
}

fn resolved(change: impl FnOnce(&mut GoalRequest)) -> Goal {
    let mut request = GoalRequest {
        from_m: [0.3, -0.1, 0.05],
        from_yaw_rad: 0.1,
        to_m: [0.32, -0.2, 0.08],
        to_yaw_rad: 0.2,
        ..goal()
    };
    change(&mut request);
    Goal::resolve(&request, &[]).unwrap()
}

#[test]
fn object_is_carried_above_start_and_destination() {
    let (kept, moved) = (GoalKind::GRASP, GoalKind::PICK_PLACE);
    for (kind, to_height_m, destination, travel_m) in [
        (kept, 0.08, ([0.3, -0.1, 0.05], 0.1), 0.1),
        (moved, 0.08, ([0.32, -0.2, 0.08], 0.2), 0.13),
        (moved, 0.02, ([0.32, -0.2, 0.02], 0.2), 0.1),
    ] {
        let goal = resolved(|g| (g.kind, g.to_m[2]) = (kind, to_height_m));
        assert_eq!(goal.destination(), destination, "{kind}");
        assert!((goal.travel_height_m() - travel_m).abs() < 1e-12, "{kind}");
        assert_eq!(goal.clearance_margin_m(), 0.0, "before the path check");
    }
}

#[test]
fn one_handed_goal_involves_only_its_hand() {
    for (kind, involved) in [
        (GoalKind::GRASP, [false, true]),
        (GoalKind::TELEOP, [false, true]),
        (GoalKind::TELEOP_BOTH, [true, true]),
        (GoalKind::ASSEMBLE, [true, true]),
    ] {
        let active = ActiveGoal::begin(&resolved(|g| g.kind = kind));
        assert_eq!(
            HandSide::BOTH.map(|side| active.involves(side)),
            involved,
            "{kind}"
        );
    }
}

#[test]
fn attached_and_streamed_goals_end_with_their_client() {
    for (kind, policy, attached) in [
        (GoalKind::GRASP, GoalPolicy::DETACHED, false),
        (GoalKind::GRASP, GoalPolicy::ATTACHED, true),
        (GoalKind::TELEOP, GoalPolicy::DETACHED, true),
    ] {
        let goal = resolved(|g| (g.kind, g.policy) = (kind, policy));
        assert_eq!(ActiveGoal::begin(&goal).is_attached(), attached, "{kind}");
    }
}
