//! Motion limiter: keeps bounds of speed, acceleration, jerk and range for any targets; arrives and
//! stays.

use atas_core::teleop::{
    Axis, Bounds, MotionLimiter, SpeedLimits, TeleopWorkspace, arm_across_middle,
};
use nalgebra::Vector3;
use proptest::prelude::*;
use robot_model::{GraspPose, GraspSide, HandSide, PerSide};
use shm_schemas::{Cause, Hand, Reason};

use crate::support::{hand_of, home, robot};

/// Rounding tolerance of position differences: a few units in the last place of 1 m.
const ROUNDING: f64 = 4e-15;

fn bounds() -> impl Strategy<Value = Bounds> {
    (0.005..0.5f64, 0.02..2.0f64, 0.005..0.5f64).prop_map(|(speed, speed_up_s, smooth_s)| Bounds {
        speed,
        acceleration: speed / speed_up_s,
        smooth_s,
    })
}

/// Jumping targets with their durations in ticks; `None` brakes.
fn targets() -> impl Strategy<Value = Vec<(Option<f64>, usize)>> {
    let target =
        prop_oneof![8 => (-0.3..0.3f64).prop_map(Some), 1 => Just(None), 1 => Just(Some(f64::NAN))];
    prop::collection::vec((target, 1..400usize), 1..12)
}

fn run(bounds: &Bounds, step_s: f64, targets: &[(Option<f64>, usize)]) -> Vec<f64> {
    let mut axis = Axis::new(0.0);
    let ticks = targets
        .iter()
        .flat_map(|(target, ticks)| vec![*target; *ticks]);
    let positions = ticks.map(|target| axis.step_towards(target, bounds, step_s));
    [0.0; 3].into_iter().chain(positions).collect()
}

fn differences(values: &[f64], step_s: f64) -> Vec<f64> {
    values.windows(2).map(|w| (w[1] - w[0]) / step_s).collect()
}

fn largest(values: &[f64]) -> f64 {
    values
        .iter()
        .fold(0.0, |most, value| f64::max(most, value.abs()))
}

proptest! {
    #![proptest_config(crate::support::cases(200))]

    #[test]
    fn motion_stays_within_all_bounds(bounds in bounds(), targets in targets(), rate_hz in prop::sample::select(vec![100.0, 1000.0, 10_000.0])) {
        let step_s = 1.0 / rate_hz;
        let positions = run(&bounds, step_s, &targets);
        let speeds = differences(&positions, step_s);
        let accelerations = differences(&speeds, step_s);
        let jerks = differences(&accelerations, step_s);
        let slack = |order: i32| 2f64.powi(order) * ROUNDING / step_s.powi(order);
        prop_assert!(largest(&speeds) <= bounds.speed + slack(1));
        prop_assert!(largest(&accelerations) <= bounds.acceleration + slack(2));
        prop_assert!(largest(&jerks) <= bounds.jerk(step_s) * (1.0 + 1e-9) + slack(3));
        prop_assert!(positions.iter().all(|p| p.is_finite()));
        // The range of start and targets bounds the hand.
        let wanted: Vec<f64> = targets.iter().filter_map(|(t, _)| t.filter(|t| t.is_finite())).chain([0.0]).collect();
        let low = wanted.iter().copied().fold(f64::INFINITY, f64::min);
        let high = wanted.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        prop_assert!(positions.iter().all(|p| *p >= low - 1e-9 && *p <= high + 1e-9), "{low} {high}");
    }

    #[test]
    fn axis_arrives_without_overshoot_and_stays(bounds in bounds(), target in -0.3..0.3f64) {
        let step_s = 1e-3;
        let way = target.abs();
        let seconds = way / bounds.speed + bounds.speed / bounds.acceleration + 40.0 * bounds.smooth_s;
        let ticks = (seconds / step_s).ceil() as usize + 10;
        let positions = run(&bounds, step_s, &[(Some(target), ticks), (Some(target), 200)]);
        prop_assert!(positions.iter().all(|p| (p * target.signum()) <= way + 1e-12 && p * target.signum() >= -1e-12));
        let (end, before) = (positions[positions.len() - 1], positions[positions.len() - 200]);
        prop_assert!((end - target).abs() < 1e-11, "{end} {target}");
        prop_assert_eq!(end.to_bits(), before.to_bits(), "bit-equal at rest");
    }

    #[test]
    fn long_motion_reaches_the_speed_limit(bounds in bounds()) {
        // The distance suffices to reach the top speed: trapezoidal profile plus low-pass.
        let step_s = 1e-3;
        let speeding_s = bounds.speed / bounds.acceleration;
        let way = bounds.speed * (2.0 * speeding_s + 0.5);
        let ticks = ((way / bounds.speed + speeding_s + 7.0 * bounds.smooth_s) / step_s) as usize + 3;
        let end = *run(&bounds, step_s, &[(Some(way), ticks)]).last().unwrap();
        prop_assert!(end > 0.998 * way, "{end} of {way}");
    }
}

const SPEEDS: SpeedLimits = SpeedLimits {
    move_m_s: 0.15,
    turn_rad_s: 0.8,
    finger_m_s: 0.02,
    speed_up_s: 0.15,
    smooth_s: 0.04,
};

fn frame(centre_m: [f64; 3], yaw_rad: f64, opening_m: f64) -> GraspPose {
    GraspPose::from_above(Vector3::from(centre_m), yaw_rad, opening_m)
}

#[test]
fn every_coordinate_tracks_its_own_target() {
    let from = GraspPose {
        tangential_m: [0.003, -0.003].into(),
        up_m: [0.001, 0.0].into(),
        root_rad: 0.1,
        ..frame([0.3, -0.2, 0.1], 0.2, 0.06)
    };
    let to = frame([0.32, -0.15, 0.05], 0.5, 0.04);
    let mut follower = MotionLimiter::new(&from);
    assert_eq!(follower.pose(), from);
    for _ in 0..4000 {
        follower.step_towards(Some(&to), &SPEEDS, 1.0, 1e-3);
    }
    let GraspPose {
        centre_m,
        half_opening_m,
        ..
    } = follower.pose();
    assert!((centre_m - to.centre_m).norm() < 1e-9);
    assert_eq!(half_opening_m, to.half_opening_m);
    assert_eq!(follower.pose().tangential_m, PerSide::repeat(0.0));
}

#[test]
fn no_pose_brakes_and_share_slows_hand_only() {
    let from = frame([0.3, -0.2, 0.1], 0.2, 0.06);
    let to = frame([0.4, -0.2, 0.1], 0.2, 0.04);
    let speeds = |share: f64| {
        let mut follower = MotionLimiter::new(&from);
        for _ in 0..300 {
            follower.step_towards(Some(&to), &SPEEDS, share, 1e-3);
        }
        let before = follower.pose();
        let after = follower.step_towards(Some(&to), &SPEEDS, share, 1e-3);
        let hand_m = (after.centre_m - before.centre_m).norm();
        (
            follower,
            hand_m,
            before.half_opening_m[GraspSide::First] - after.half_opening_m[GraspSide::First],
        )
    };
    let (mut follower, full_m, finger_m) = speeds(1.0);
    let (_, tenth_m, slow_finger_m) = speeds(0.1);
    assert!((tenth_m / full_m - 0.1).abs() < 0.01, "{tenth_m} {full_m}");
    assert_eq!(finger_m.to_bits(), slow_finger_m.to_bits());
    for _ in 0..700 {
        follower.step_towards(None, &SPEEDS, 1.0, 1e-3);
    }
    let stands = follower.pose();
    assert!(stands.centre_m.x < 0.36, "it stops on the way");
    let after = follower.step_towards(None, &SPEEDS, 1.0, 1e-3);
    assert!((after.centre_m - stands.centre_m).norm() < 1e-9);
}

/// Pose in the workspace of a side, from shares of each range, corners included.
fn pose_in(space: &TeleopWorkspace, [x, y, z, opening]: [f64; 4], yaw_rad: f64) -> GraspPose {
    let at = |[low, high]: [f64; 2], share: f64| low + (high - low) * share;
    let [x_m, y_m, z_m] = space.centre_m;
    let centre_m = [at(x_m, x), at(y_m, y), at(z_m, z)];
    frame(centre_m, yaw_rad, at(space.opening_m, opening).max(0.004))
}

/// Position error of the fingertips, and the reason if the arm reaches across the middle.
fn posture(side: HandSide, pose: &GraspPose, yaw_rad: f64) -> (f64, Option<Cause>) {
    let hand = robot().hand(side);
    let yaw_rad = hand.closing_yaw_rad(&pose.centre_m, yaw_rad);
    let pose = GraspPose {
        closing_yaw_rad: yaw_rad,
        ..*pose
    };
    let from = hand_of(&home(), side);
    let posture = hand.solve(&from, &pose.target(hand), 200);
    let across = arm_across_middle(hand, &posture.q);
    (posture.tip_error_m, across.map(|reason| reason.cause()))
}

proptest! {
    #![proptest_config(crate::support::cases(300))]

    #[test]
    fn workspace_poses_are_reachable_on_own_side(
        shares in prop::array::uniform4(prop_oneof![Just(0.0), Just(1.0), 0.0..1.0f64]),
        yaw_rad in -3.2..3.2f64,
        left in any::<bool>(),
    ) {
        let side = if left { HandSide::Left } else { HandSide::Right };
        let pose = pose_in(&TeleopWorkspace::new(robot(), side).expect("the robot file has a workspace"), shares, yaw_rad);
        let (error_m, across) = posture(side, &pose, yaw_rad);
        prop_assert!(error_m < 1e-4, "{pose:?}: {error_m}");
        prop_assert_eq!(across, None, "{:?}", pose);
    }
}

#[test]
fn arm_across_the_middle_is_detected() {
    let side = HandSide::Right;
    let hand = robot().hand(side);
    let over = frame([0.32, 0.04, 0.05], 0.0, 0.05);
    let posture = hand.posture_for(&over).expect("posture across the middle");
    let reason = arm_across_middle(hand, &posture.q).expect("across");
    assert!(
        matches!(
            reason,
            Reason::AcrossTheMiddle {
                hand: Hand::RIGHT,
                ..
            }
        ),
        "{reason:?}"
    );
    let beside = frame([0.32, -0.2, 0.05], 0.0, 0.05);
    let posture = hand.posture_for(&beside).expect("posture on its side");
    assert_eq!(arm_across_middle(hand, &posture.q), None);
    let broken = hand_of(&home(), side) * f64::NAN;
    assert!(arm_across_middle(hand, &broken).is_some());
}
