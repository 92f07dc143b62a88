//! Collision capsules: positions, and the clearance between them.

use nalgebra::Vector3;
use proptest::prelude::*;
use robot_model::{Capsule, Capsules, GraspPose, HandSide, clearance_m};

use crate::support::{ROBOT, assert_near};

fn capsule(a: [f64; 3], b: [f64; 3], radius_m: f64) -> Capsule {
    Capsule {
        a_m: Vector3::from(a),
        b_m: Vector3::from(b),
        radius_m,
        joint: 0,
    }
}

#[test]
fn clearance_of_known_pairs() {
    let along_x = capsule([0.0, 0.0, 0.0], [1.0, 0.0, 0.0], 0.1);
    for (what, other, wanted_m) in [
        (
            "crossing above",
            capsule([0.5, -1.0, 0.5], [0.5, 1.0, 0.5], 0.1),
            0.3,
        ),
        (
            "end to end",
            capsule([1.5, 0.0, 0.0], [2.0, 0.0, 0.0], 0.1),
            0.3,
        ),
        (
            "parallel",
            capsule([0.2, 0.4, 0.0], [0.7, 0.4, 0.0], 0.1),
            0.2,
        ),
        (
            "parallel, apart",
            capsule([-2.0, 0.0, 0.0], [-1.0, 0.0, 0.0], 0.1),
            0.8,
        ),
        (
            "sphere beside",
            capsule([0.5, 0.3, 0.0], [0.5, 0.3, 0.0], 0.05),
            0.15,
        ),
        (
            "overlapping",
            capsule([0.5, 0.0, 0.0], [0.5, 1.0, 0.0], 0.1),
            -0.2,
        ),
        ("itself", along_x, -0.2),
    ] {
        let is = clearance_m(&[along_x], &[other]);
        assert!(
            (is - wanted_m).abs() < 1e-12,
            "{what}: {is}, wanted {wanted_m}"
        );
    }
}

#[test]
fn empty_set_has_infinite_gap_and_nan_is_unsafe() {
    let fine = capsule([0.0; 3], [1.0, 0.0, 0.0], 0.1);
    let lost = capsule([0.0, f64::NAN, 0.0], [1.0, 0.0, 0.0], 0.1);
    let far = capsule([0.0, f64::INFINITY, 0.0], [1.0, 0.0, 0.0], 0.1);
    assert_eq!(clearance_m(&[fine], &[]), f64::INFINITY);
    assert_eq!(clearance_m(&[fine, lost, fine], &[fine]), f64::NEG_INFINITY);
    assert_eq!(clearance_m(&[fine], &[far]), f64::NEG_INFINITY);
}

fn any_capsule() -> impl Strategy<Value = Capsule> {
    let point = || prop::array::uniform3(-1.0..1.0_f64);
    (point(), point(), 0.01..0.1_f64).prop_map(|(a, b, radius_m)| capsule(a, b, radius_m))
}

/// Returns the distance between sampled points of both segments: an upper bound, at most half a
/// grid step too large.
fn sampled_clearance_m(one: &Capsule, two: &Capsule, steps: usize) -> f64 {
    let on = |capsule: &Capsule, index: usize| {
        capsule.a_m.lerp(&capsule.b_m, index as f64 / steps as f64)
    };
    let mut nearest = f64::INFINITY;
    for i in 0..=steps {
        for j in 0..=steps {
            nearest = nearest.min((on(one, i) - on(two, j)).norm());
        }
    }
    nearest - one.radius_m - two.radius_m
}

proptest! {
    #![proptest_config(crate::support::cases(64))]

    #[test]
    fn clearance_equals_the_sampled_one(
        ours in prop::collection::vec(any_capsule(), 1..4),
        theirs in prop::collection::vec(any_capsule(), 1..4),
    ) {
        let sampled = ours.iter().flat_map(|a| theirs.iter().map(move |b| sampled_clearance_m(a, b, 100)))
            .fold(f64::INFINITY, f64::min);
        let is = clearance_m(&ours, &theirs);
        prop_assert!(is <= sampled + 1e-12 && is >= sampled - 0.035, "{} against {}", is, sampled);
    }
}

/// The bodies equal those of the prototype's collision check.
#[test]
fn capsules_lie_along_the_links() {
    let hand = ROBOT.hand(HandSide::Left);
    let pose = hand.forward(hand.reference());
    let capsules = hand.capsules(&pose);
    assert_eq!(capsules.len(), 15);
    let find = |joint: usize| {
        capsules
            .iter()
            .find(|capsule| capsule.joint == joint)
            .expect("a body")
    };
    for (joint, radius_m) in [
        (1, 0.040),
        (2, 0.033),
        (5, 0.012),
        (6, 0.011),
        (8, 0.012),
        (9, 0.011),
    ] {
        let body = find(joint);
        assert_eq!(body.radius_m, radius_m);
        assert_near("start", body.a_m, pose.frame_origin_m(joint), 1e-12);
        assert_near("end", body.b_m, pose.frame_origin_m(joint + 1), 1e-12);
    }
    let palm = find(4);
    assert_near(
        "palm",
        palm.a_m.lerp(&palm.b_m, 0.5),
        pose.frame_origin_m(5).lerp(&pose.frame_origin_m(8), 0.5),
        1e-12,
    );
    for finger in 0..2 {
        let dome = capsules
            .iter()
            .find(|body| (body.a_m - pose.tip_m(finger)).norm() < 1e-12 && body.a_m == body.b_m);
        assert_eq!(dome.expect("a dome").radius_m, hand.tip_radius_m()[finger]);
    }
}

/// Both arms with their hands apart, and reaching for the same place.
#[test]
fn arms_meet_only_where_both_reach() {
    let placed = |side: HandSide, centre: [f64; 3]| {
        let hand = ROBOT.hand(side);
        let grasp = GraspPose::from_above(Vector3::from(centre), 90_f64.to_radians(), 0.06);
        hand.capsules(&hand.forward(&hand.posture_for(&grasp).expect("reachable").q))
    };
    let right = placed(HandSide::Right, [0.3, -0.14, 0.1]);
    assert!(clearance_m(&placed(HandSide::Left, [0.3, 0.14, 0.1]), &right) > 0.02);
    assert!(
        clearance_m(
            &placed(HandSide::Left, [0.3, 0.0, 0.1]),
            &placed(HandSide::Right, [0.3, 0.02, 0.1])
        ) < 0.0
    );
}

#[test]
fn full_set_rejects_more_capsules() {
    let mut set = Capsules::new();
    let body = capsule([0.0; 3], [0.0; 3], 0.1);
    let taken = (0..40).filter(|_| set.push(body, 0)).count();
    assert_eq!(
        (taken, set.len()),
        (robot_model::CAPSULES_MAX, robot_model::CAPSULES_MAX)
    );
}
