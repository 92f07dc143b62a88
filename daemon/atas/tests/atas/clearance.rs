//! Clearance check before motion; accepted goals keep their clearance in every tick.

use crate::support::{hand_of, robot};
use crate::world::{World, grasp, start};
use atas_core::check::{self, CLEARANCE_M, GoalContext};
use atas_core::limits::DISPLACED_MAX_M;
use atas_core::planning;
use atas_core::tasks::{GRASP, Motion, STEPS_MAX, Step, Task, Waypoint};
use atas_core::{OperatorRequest, Settings};
use nalgebra::Vector3;
use robot_model::{GraspPose, HandSide, HandVector, RobotVector, nearest};
use shm_schemas::{Cause, GoalField, GoalKind, GoalRequest, GoalState, Mode, Reason, Text};

fn tour() -> Task {
    let reach = |waypoint| Step {
        motion: Motion::Reach(waypoint),
        ..GRASP.acting[0]
    };
    let waypoints = [
        Waypoint::BeforeSource,
        Waypoint::Source,
        Waypoint::Lifted,
        Waypoint::OverTarget,
        Waypoint::Above,
        Waypoint::Home,
    ];
    Task::validated("tour", &waypoints.map(reach), None).unwrap()
}

fn posture(side: HandSide, centre_m: [f64; 3], opening_m: f64) -> HandVector {
    let (hand, centre_m) = (robot().hand(side), Vector3::from(centre_m));
    let yaw_rad = hand.closing_yaw_rad(&centre_m, 0.5);
    let frame = GraspPose::from_above(centre_m, yaw_rad, opening_m);
    hand.posture_for(&frame).unwrap().q
}

fn at_home(side: HandSide) -> HandVector {
    let hand = robot().hand(side);
    let now = GraspPose::from_above(Vector3::new(0.3, 0.0, 0.1), 1.0, 0.05);
    hand.posture_for(&planning::home_pose(hand, &now))
        .unwrap()
        .q
}

/// World in READY with the right arm at home and the left arm in this posture.
fn world(left_rad: HandVector) -> World {
    let mut world = World::new();
    for (side, q) in [
        (HandSide::Left, left_rad),
        (HandSide::Right, at_home(HandSide::Right)),
    ] {
        world.q[robot().joint_range(side)].copy_from_slice(&q);
    }
    world.run(50);
    assert_eq!(world.mode(), Mode::READY);
    world
}

fn gap_m(q: &RobotVector) -> f64 {
    let bodies = |side| {
        let hand = robot().hand(side);
        hand.capsules(&hand.forward(&hand_of(q, side)))
    };
    nearest(&bodies(HandSide::Right), &bodies(HandSide::Left)).gap_m
}

fn check(world: &World, request: &GoalRequest) -> Result<atas_core::Goal, Reason> {
    check::check(request, &world.controller.goal_context(robot(), &[tour()]))
}

/// Reproducible random numbers from 0 to 1.
struct Numbers(u64);

impl Numbers {
    fn next(&mut self) -> f64 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1);
        (self.0 >> 40) as f64 / (1_u64 << 24) as f64
    }

    fn between(&mut self, [lower, upper]: [f64; 2]) -> f64 {
        lower + (upper - lower) * self.next()
    }
}

/// Random goals of both arms over the middle of the table.
#[test]
fn accepted_goals_keep_clearance_in_every_tick() {
    let mut numbers = Numbers(2026);
    let mut place = |y_m: [f64; 2]| {
        let [x, y, z] = [[0.23, 0.39], y_m, [0.03, 0.13]].map(|range| numbers.between(range));
        [x, y, z]
    };
    let (mut accepted, mut refused) = (0, 0);
    for _ in 0..30 {
        let mut world = world(posture(HandSide::Left, place([-0.05, 0.15]), 0.06));
        let request = GoalRequest {
            kind: GoalKind::CUSTOM,
            task: Text::new("tour"),
            from_m: place([-0.15, 0.05]),
            to_m: place([-0.15, 0.05]),
            ..grasp()
        };
        if gap_m(&world.q) < CLEARANCE_M {
            continue;
        }
        match check(&world, &request) {
            Err(reason) => {
                assert_eq!(reason.cause(), Cause::ARMS_COLLIDE, "{reason}");
                refused += 1;
            }
            Ok(goal) => {
                accepted += 1;
                world.request(OperatorRequest::Start(goal));
                let mut least_m = f64::INFINITY;
                while !world.controller.goal().unwrap().state.is_final() {
                    world.tick();
                    least_m = least_m.min(gap_m(&world.q));
                }
                assert_eq!(world.controller.goal().unwrap().state, GoalState::SUCCEEDED);
                assert!(
                    least_m >= CLEARANCE_M,
                    "clearance {least_m} m in {request:?}"
                );
            }
        }
    }
    assert!(
        accepted > 8 && refused > 8,
        "{accepted} accepted, {refused} refused"
    );
}

/// The clearance margin must equal the lateral offset up to which the goal would be accepted.
#[test]
fn off_centre_grasp_within_margin_keeps_clearance() {
    let mut numbers = Numbers(77);
    let mut tried = 0;
    for _ in 0..120 {
        let mut place = |y_m: [f64; 2]| {
            let [x, y, z] = [[0.25, 0.37], y_m, [0.04, 0.12]].map(|range| numbers.between(range));
            [x, y, z]
        };
        let world = world(posture(HandSide::Left, place([0.0, 0.15]), 0.06));
        let request = GoalRequest {
            kind: GoalKind::CUSTOM,
            task: Text::new("tour"),
            from_m: place([-0.13, 0.0]),
            to_m: place([-0.25, -0.10]),
            ..grasp()
        };
        let Ok(goal) = check(&world, &request) else {
            continue;
        };
        // Larger than any accepted offset, so that more goals reach their bound.
        let spare_m = goal.clearance_margin_m().min(2.0 * DISPLACED_MAX_M);
        tried += usize::from(spare_m < 2.0 * DISPLACED_MAX_M);
        for (x, y) in [(1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0)] {
            let mut beside = request;
            beside.from_m[0] += x * spare_m;
            beside.from_m[1] += y * spare_m;
            let collides = check(&world, &beside)
                .err()
                .filter(|r| r.cause() == Cause::ARMS_COLLIDE);
            assert_eq!(collides, None, "{spare_m} m off-centre of {request:?}");
        }
    }
    assert!(tried > 5, "only {tried} goals had a small clearance margin");
}

/// The reason names the colliding bodies; nothing has moved.
#[test]
fn collision_with_other_arm_is_rejected_by_name() {
    let world = world(posture(HandSide::Left, [0.30, -0.02, 0.06], 0.06));
    let before_rad = world.q;
    let into = GoalRequest {
        from_m: [0.30, -0.04, 0.05],
        ..grasp()
    };
    let reason = check(&world, &into).unwrap_err();
    assert_eq!(reason.cause(), Cause::ARMS_COLLIDE);
    let message = reason.to_string();
    assert!(
        message.starts_with("the right ") && message.contains(" mm of the left "),
        "{message}"
    );
    let beside = GoalRequest {
        from_m: [0.30, -0.20, 0.05],
        ..grasp()
    };
    assert!(check(&world, &beside).is_ok());
    let over = GoalRequest {
        kind: GoalKind::PICK_PLACE,
        to_m: [0.30, -0.04, 0.05],
        ..beside
    };
    assert_eq!(
        check(&world, &over).unwrap_err().cause(),
        Cause::ARMS_COLLIDE
    );
    let mut after = world.clone();
    after.run(100);
    assert_eq!(after.q, before_rad);
}

/// Arms that are already too close may move apart.
#[test]
fn release_is_accepted_with_touching_arms() {
    let mut world = World::ready();
    assert!(
        gap_m(&world.q) < 0.0,
        "the initial posture crosses the fingers"
    );
    let release = GoalRequest {
        kind: GoalKind::RELEASE,
        ..grasp()
    };
    assert!(check(&world, &release).is_ok());
    let outputs = world.request(start(release));
    assert_eq!(outputs.goal_update.unwrap().state, GoalState::ACCEPTED);
}

#[test]
fn unreachable_openings_and_heights_are_rejected() {
    let world = world(at_home(HandSide::Left));
    let clearance_m = Settings::default().motion.clearance_m;
    let cause = |change: fn(&mut GoalRequest)| {
        let mut request = GoalRequest {
            from_m: [0.3, -0.2, 0.06],
            ..grasp()
        };
        change(&mut request);
        check(&world, &request).map(|_| ())
    };
    assert_eq!(cause(|g| g.width_m = 0.0999), Ok(()));
    let widest_m = 0.11 - 2.0 * clearance_m;
    assert_eq!(
        cause(|g| g.width_m = 0.1001),
        Err(Reason::Unreachable {
            field: GoalField::WIDTH,
            value: 0.1001,
            limit: widest_m,
        })
    );
    // The height from which the hand descends needs a posture as well.
    let far = GoalRequest {
        from_m: [0.4, -0.3, 0.2],
        lift_m: 0.0,
        ..grasp()
    };
    assert!(check(&world, &far).is_ok());
    let mut settings = Settings::default();
    settings.motion.descend_m = 0.6;
    let now = GoalContext {
        settings: &settings,
        ..world.controller.goal_context(robot(), &[])
    };
    let reason = check::check(&far, &now).unwrap_err();
    let place = GoalField::FROM_X;
    assert!(
        matches!(reason, Reason::NoPosture { place: at, .. } if at == place),
        "{reason:?}"
    );
}

/// Hands that do not wait for each other may be anywhere on their paths at the same time.
#[test]
fn simultaneous_paths_are_compared_at_all_times() {
    let reach = |waypoint| Step {
        motion: Motion::Reach(waypoint),
        ..GRASP.acting[0]
    };
    let acting = [Waypoint::BeforeSource, Waypoint::Home].map(reach);
    let helping = [Waypoint::BeforeSource, Waypoint::Source, Waypoint::Home].map(reach);
    let own = Task::validated("both", &acting, Some(&helping)).unwrap();
    let world = world(at_home(HandSide::Left));
    let cause = |from_m: [f64; 3]| {
        let request = GoalRequest {
            kind: GoalKind::CUSTOM,
            task: Text::new("both"),
            from_m,
            to_m: [0.30, -0.04, 0.12],
            helper_width_m: 0.06,
            ..grasp()
        };
        let tasks = [own];
        let now = world.controller.goal_context(robot(), &tasks);
        check::check(&request, &now)
            .err()
            .map(|reason| reason.cause())
    };
    assert_eq!(cause([0.30, -0.28, 0.05]), None, "far apart");
    let near = [0.30, -0.04, 0.05];
    assert_eq!(cause(near), Some(Cause::ARMS_COLLIDE), "same place");
}

/// Independent hands need a check of every pair of postures, which is bounded in time.
#[test]
fn task_with_unbounded_check_is_rejected() {
    let reach = |waypoint| Step {
        motion: Motion::Reach(waypoint),
        ..GRASP.acting[0]
    };
    let there_and_back = |step| [Waypoint::BeforeSource, Waypoint::Home][step % 2];
    let steps: [Step; STEPS_MAX - 1] = core::array::from_fn(|step| reach(there_and_back(step)));
    let own = Task::validated("endless", &steps, Some(&steps)).unwrap();
    let world = world(at_home(HandSide::Left));
    let request = GoalRequest {
        kind: GoalKind::CUSTOM,
        task: Text::new("endless"),
        from_m: [0.30, -0.28, 0.05],
        to_m: [0.30, 0.28, 0.12],
        helper_width_m: 0.06,
        ..grasp()
    };
    let tasks = [own];
    let now = world.controller.goal_context(robot(), &tasks);
    let reason = check::check(&request, &now).unwrap_err();
    assert_eq!(reason.cause(), Cause::TASK_TOO_LONG, "{reason}");
}
