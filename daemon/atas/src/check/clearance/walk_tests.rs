//! Tests of the simulated motion of one hand.

use super::*;
use crate::planning::home_pose;
use crate::sensor_setup::SensorSetup;
use crate::tasks::GRASP;
use nalgebra::Vector3;
use robot_model::RobotModel;
use shm_schemas::{GoalKind, GoalRequest, Hand};

/// Robot with its arms at home, and a goal of the right hand.
struct Scene {
    robot: RobotModel,
    wiring: SensorSetup,
    settings: Settings,
    q: RobotVector,
    goal: Goal,
}

impl Scene {
    fn new(kind: GoalKind) -> Self {
        Self::of(RobotModel::two_hand_arm().expect("built in"), kind)
    }

    fn of(robot: RobotModel, kind: GoalKind) -> Self {
        let mut q = RobotVector::zeros(robot.joint_count());
        for side in robot.sides() {
            let hand = robot.hand(side);
            let now = GraspPose::from_above(Vector3::new(0.3, 0.0, 0.1), 0.0, 0.05);
            let posture = hand.posture_for(&home_pose(hand, &now));
            q[robot.joint_range(side)].copy_from_slice(&posture.expect("home").q);
        }
        let request = GoalRequest {
            kind,
            hand: Hand::RIGHT,
            from_m: [0.3, -0.12, 0.05],
            to_m: [0.3, -0.2, 0.07],
            width_m: 0.04,
            helper_width_m: 0.06,
            lift_m: 0.05,
            ..GoalRequest::default()
        };
        Self {
            wiring: SensorSetup::from_robot(&robot),
            settings: Settings::default(),
            goal: Goal::resolve(&request, &[]).expect("valid codes"),
            robot,
            q,
        }
    }

    fn context(&self) -> GoalContext<'_> {
        GoalContext {
            robot: &self.robot,
            wiring: &self.wiring,
            settings: &self.settings,
            tasks: &[],
            commanded_position: Some(&self.q),
        }
    }

    fn walker<'a>(&'a self, side: HandSide, samples_left: &'a Cell<u32>) -> PathWalker<'a> {
        PathWalker::new(&self.goal, side, (&self.context(), &self.q), samples_left)
    }
}

fn opening_m(walker: &PathWalker<'_>) -> f64 {
    walker.pose.half_opening_m.iter().sum()
}

#[test]
fn object_is_closed_on_carried_and_lowered() {
    let (scene, left) = (Scene::new(GoalKind::PICK_PLACE), Cell::new(SAMPLES_MAX));
    let mut walker = scene.walker(HandSide::Right, &left);
    let count = walker.steps().len();
    for index in 0..count {
        let step = walker.steps()[index];
        let was_at_target = walker.at_target;
        let before = walker.pose;
        let mut samples = 0;
        let mut visit = |sample: &Sample| {
            samples += 1;
            assert_eq!(sample.at_target, was_at_target, "{}", step.name.as_str());
            Ok(())
        };
        walker
            .run_steps(index..index + 1, &mut visit)
            .expect("reachable");
        let over = step.motion.waypoint() == Some(Waypoint::OverTarget);
        assert_eq!(
            walker.at_target,
            was_at_target || over,
            "{}",
            step.name.as_str()
        );
        let place = if walker.at_target {
            GoalField::TO_X
        } else {
            GoalField::FROM_X
        };
        assert_eq!((walker.place, walker.next), (place, index + 1));
        if matches!(
            step.transition,
            Transition::AllTouched | Transition::Gripped
        ) {
            assert!(
                (opening_m(&walker) - 0.04).abs() < 1e-9,
                "{}",
                step.name.as_str()
            );
        }
        if step.motion == Motion::Lower {
            let lowest_m = before.centre_m.z - walker.waypoints.lowering_m();
            let lowest = with_height(&before, lowest_m);
            let expected = with_height(&before, walker.waypoints.expected_height_m());
            assert_eq!(walker.pose, expected);
            // Each leg of the path, which stays in place, has one sample.
            let stays = Path::stationary(before).leg_ends().into_iter().count() as u32;
            let lowers = sample_count(&before, &lowest) + sample_count(&lowest, &expected);
            assert_eq!(samples, stays + lowers);
            assert!(before.centre_m.z > expected.centre_m.z && expected.centre_m.z > lowest_m);
        }
    }
    assert!(walker.at_target, "the object was carried");
    assert!(left.get() > 0 && left.get() < SAMPLES_MAX);
}

/// The first corner is reached after 2 samples, the others after 3, 4 and 3 more.
#[test]
fn cap_is_turned_along_a_square() {
    let mut scene = Scene::new(GoalKind::SCREW);
    (
        scene.settings.screw.travel_m,
        scene.settings.screw.clearance_m,
    ) = (0.007, 0.009);
    let square = Step {
        motion: Motion::Square,
        ..GRASP.acting[0]
    };
    for (samples, turned_m, away_m) in [
        (2, 0.007, 0.0),
        (5, 0.007, 0.009),
        (9, -0.007, 0.009),
        (12, -0.007, 0.0),
    ] {
        let left = Cell::new(samples);
        let mut walker = scene.walker(HandSide::Right, &left);
        let half_m = walker.pose.half_opening_m;
        let sense = walker.waypoints.turning();
        let result = walker.finish_step(&square, &mut |_| Ok(()));
        assert_eq!(result.is_ok(), samples == 12, "{result:?}");
        assert_eq!(left.get(), 0, "the budget ends at a corner");
        for (side, turned_m) in [(GraspSide::First, turned_m), (GraspSide::Second, -turned_m)] {
            let found_m = walker.pose.tangential_m[side];
            assert!(
                (found_m - sense * turned_m).abs() < 1e-12,
                "{samples}: {found_m} m"
            );
            let opened_m = walker.pose.half_opening_m[side] - half_m[side];
            assert!((opened_m - away_m).abs() < 1e-12, "{samples}: {opened_m} m");
        }
    }
}

#[test]
fn hands_wait_for_each_other_at_meeting_points() {
    let (scene, left) = (Scene::new(GoalKind::ASSEMBLE), Cell::new(SAMPLES_MAX));
    let [mut acting, mut helping] =
        [HandSide::Right, HandSide::Left].map(|side| scene.walker(side, &left));
    assert_eq!((acting.reached, helping.reached), (1, 0));
    assert_eq!(acting.runnable_steps(0), 0..0, "the bottle is not held");
    assert_eq!(helping.runnable_steps(1), 0..7);
    (helping.next, acting.next) = (7, 3);
    helping.reach_meeting_point();
    assert_eq!(helping.reached, 2);
    let steps = acting.steps().len();
    assert_eq!(
        acting.runnable_steps(1),
        3..steps - 1,
        "up to the last meeting point"
    );
    assert_eq!(acting.runnable_steps(2), 3..steps);
}

#[test]
fn samples_follow_the_path_to_its_end() {
    let (scene, left) = (Scene::new(GoalKind::GRASP), Cell::new(SAMPLES_MAX));
    let mut walker = scene.walker(HandSide::Right, &left);
    let to = GraspPose {
        centre_m: walker.pose.centre_m + Vector3::new(0.0, -0.03, 0.05),
        ..walker.pose
    };
    let mut before = walker.bodies();
    let mut visited = 0;
    let mut visit = |sample: &Sample| {
        let moved_m = farthest_move_m(&before, &sample.bodies);
        assert!((0.001..0.05).contains(&moved_m), "{moved_m} m");
        assert!((sample.uncertainty_m - moved_m / 2.0).abs() < 1e-12);
        before.clone_from(&sample.bodies);
        visited += 1;
        Ok(())
    };
    let expected = sample_count(&walker.pose, &to);
    walker.move_to(to, &mut visit).expect("reachable");
    assert_eq!((visited, walker.pose), (expected, to));
    let reached = grasp_pose(walker.hand, &walker.hand.forward(&walker.q));
    assert!(
        (reached.centre_m - to.centre_m).norm() < 1e-5,
        "{reached:?}"
    );
}

/// Fingertips at different heights turn rigid jaws. Those of a turning jaw tilt as it opens.
#[test]
fn path_ends_with_aligned_fingertips() {
    let rigid = || RobotModel::find("arm7-gripper").expect("built in");
    let turning = || {
        RobotModel::load(
            include_str!("../../../../robot/tests/robots/angular-jaw.urdf"),
            include_str!("../../../../robot/tests/robots/angular-jaw.toml"),
        )
        .expect("the robot loads")
    };
    for (case, robot, opening_m, up_m, samples, is_accepted) in [
        ("3.8° at the end", rigid(), 0.03, [0.0, 0.002], 1, true),
        ("7.4° at the end", rigid(), 0.03, [0.0, 0.0039], 1, false),
        ("18° at the end", rigid(), 0.03, [0.0, 0.01], 3, false),
        ("15° on the way", rigid(), 0.03, [0.012, 0.0], 3, true),
        ("turning jaw", turning(), 0.06, [0.0, 0.0], 1, true),
    ] {
        let (scene, left) = (Scene::of(robot, GoalKind::GRASP), Cell::new(SAMPLES_MAX));
        let mut walker = scene.walker(HandSide::Right, &left);
        let [from, to] = up_m.map(|up_m| GraspPose {
            half_opening_m: PerSide::repeat(opening_m / 2.0),
            up_m: PerSide::new(up_m, -up_m),
            ..walker.pose
        });
        walker.solve_posture(&from, false).expect("reachable");
        walker.pose = from;
        let result = walker.move_to(to, &mut |_| Ok(()));
        assert_eq!(result.is_ok(), is_accepted, "{case}: {result:?}");
        assert_eq!(SAMPLES_MAX - left.get(), samples, "{case}");
    }
}

#[test]
fn unreachable_sample_names_the_place() {
    let (scene, left) = (Scene::new(GoalKind::GRASP), Cell::new(SAMPLES_MAX));
    let mut walker = scene.walker(HandSide::Right, &left);
    for (centre_m, expected) in [
        ([0.9, -0.1, 0.1], GoalField::FROM_X),
        ([f64::NAN, -0.1, 0.1], GoalField::TO_X),
    ] {
        walker.place = expected;
        let pose = GraspPose {
            centre_m: Vector3::from(centre_m),
            ..walker.pose
        };
        for rests in [false, true] {
            let reason = walker.solve_posture(&pose, rests).unwrap_err();
            let Reason::NoPosture { place, error_m } = reason else {
                panic!("{reason:?}")
            };
            assert_eq!(place, expected);
            let is_far = error_m.is_nan() || error_m > PATH_ERROR_MAX_M;
            assert!(is_far, "{reason:?}");
        }
    }
}

#[test]
fn check_ends_with_its_number_of_samples() {
    let (scene, left) = (Scene::new(GoalKind::GRASP), Cell::new(3));
    let mut walker = scene.walker(HandSide::Right, &left);
    let to = GraspPose {
        centre_m: walker.pose.centre_m + Vector3::new(0.0, 0.0, 0.02),
        ..walker.pose
    };
    let reason = walker.move_to(to, &mut |_| Ok(())).unwrap_err();
    let (postures, limit) = (SAMPLES_MAX, SAMPLES_MAX);
    assert_eq!(reason, Reason::TaskTooLong { postures, limit });
}
