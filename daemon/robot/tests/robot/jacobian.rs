//! Jacobians against central differences, and the compliance that follows from them.

use nalgebra::{Matrix3, Vector3};
use proptest::prelude::*;
use robot_model::{HandPose, HandSide, HandVector};

use crate::support::{JOINTS, ROBOT, assert_near, between_limits, degrees, fractions, side};

/// Half width of the central difference, radians: truncation h²·0.6 m and rounding ε/h meet near
/// 1e-10.
const H_RAD: f64 = 1e-5;
const TOLERANCE: f64 = 1e-9;

proptest! {
    #[test]
    fn every_column_equals_the_central_difference(side in side(), fractions in fractions()) {
        let hand = ROBOT.hand(side);
        let q = between_limits(hand, &fractions);
        let pose = hand.forward(&q);
        let jacobian = hand.jacobian(&pose);
        for joint in 0..JOINTS {
            let mut step = HandVector::zeros(JOINTS);
            step[joint] = H_RAD;
            let (after, before) = (hand.forward(&(q + step)), hand.forward(&(q - step)));
            let slope = |of: &dyn Fn(&HandPose) -> Vector3<f64>| (of(&after) - of(&before)) / (2.0 * H_RAD);
            let hand_axis = jacobian.hand_axis.column(joint).into_owned();
            assert_near("hand axis", hand_axis, slope(&HandPose::hand_axis), TOLERANCE);
            for finger in 0..hand.fingertip_count() {
                let tip = jacobian.tips[finger].position.column(joint).into_owned();
                assert_near("tip", tip, slope(&|pose| pose.tip_m(finger)), TOLERANCE);
                let dome = jacobian.tips[finger].dome_axis.column(joint).into_owned();
                assert_near("dome axis", dome, slope(&|pose| pose.dome_axis(finger)), TOLERANCE);
                let turn = jacobian.tips[finger].angular.column(joint).into_owned();
                let x = pose.base_from_tip()[finger].x_axis();
                assert_near("turn", turn.cross(&x), slope(&|pose| pose.base_from_tip()[finger].x_axis()), TOLERANCE);
            }
        }
    }

    #[test]
    fn compliance_is_symmetric_and_positive(side in side(), fractions in fractions()) {
        let hand = ROBOT.hand(side);
        let jacobian = hand.jacobian(&hand.forward(&between_limits(hand, &fractions)));
        for c in jacobian.tip_compliance(&servo_stiffness()).expect("positive stiffness") {
            prop_assert!((c - c.transpose()).norm() <= 1e-18);
            prop_assert!(c.diagonal().iter().all(|value| *value >= 0.0) && c.determinant() >= -1e-18);
        }
    }
}

/// Joint stiffness of the simulated servos, N·m/rad.
fn servo_stiffness() -> HandVector {
    ROBOT.hand(HandSide::Left).stiffness()
}

#[test]
fn servos_equal_the_robot_design() {
    let wanted = [
        6480.0, 6480.0, 2880.0, 1280.0, 512.0, 80.0, 40.0, 40.0, 80.0, 40.0, 40.0,
    ];
    for side in HandSide::BOTH {
        assert_eq!(ROBOT.hand(side).stiffness(), HandVector::from(wanted));
    }
}

/// Fingers alone on a rigid arm: 4.9–5.7 kN/m closing, 5.1–5.8 tangential, 98 vertical on 30 mm
/// objects (prototype).
#[test]
fn finger_stiffness_equals_the_prototype() {
    let hand = ROBOT.hand(HandSide::Right);
    let q = degrees([
        6.69, -14.52, 97.02, 7.84, 36.68, 1.01, -8.71, 38.52, 1.01, -5.93, 36.14,
    ]);
    let mut stiffness = servo_stiffness();
    stiffness[..5].fill(1e12);
    let pose = hand.forward(&q);
    let c = hand
        .jacobian(&pose)
        .tip_compliance(&stiffness)
        .expect("positive stiffness");
    for (finger, c) in c[..2].iter().enumerate() {
        let closing = pose.dome_axis(finger);
        let tangential = Vector3::z().cross(&closing).normalize();
        let k_n_m = |direction: &Vector3<f64>| constrained_stiffness(c, direction);
        assert!(
            (4.8e3..5.8e3).contains(&k_n_m(&closing)),
            "closing {}",
            k_n_m(&closing)
        );
        assert!(
            (5.0e3..5.9e3).contains(&k_n_m(&tangential)),
            "tangential {}",
            k_n_m(&tangential)
        );
    }
}

/// Force along `direction` per motion along it: 1 / (dᵀ·C·d).
fn constrained_stiffness(c: &Matrix3<f64>, direction: &Vector3<f64>) -> f64 {
    1.0 / direction.dot(&(c * direction))
}

#[test]
fn compliance_refuses_a_stiffness_that_is_not_positive() {
    let hand = ROBOT.hand(HandSide::Left);
    let jacobian = hand.jacobian(&hand.forward(hand.reference()));
    for bad in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let mut stiffness = servo_stiffness();
        stiffness[7] = bad;
        assert_eq!(jacobian.tip_compliance(&stiffness), None, "stiffness {bad}");
    }
}
