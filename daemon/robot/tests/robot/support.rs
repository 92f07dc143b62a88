//! Shared helpers: the built-in robot, joint positions within its limits, comparisons.

use std::sync::LazyLock;

use nalgebra::Vector3;
use proptest::prelude::*;
use robot_model::{HandModel, HandSide, HandVector, RobotModel};

/// Joints of one of its hands.
pub(crate) const JOINTS: usize = 11;

/// The built-in robot, loaded once.
pub(crate) static ROBOT: LazyLock<RobotModel> =
    LazyLock::new(|| RobotModel::two_hand_arm().expect("the built-in URDF loads"));

/// Cases of a property test; few under Miri, which is a thousand times slower.
pub(crate) fn cases(native: u32) -> ProptestConfig {
    ProptestConfig::with_cases(if cfg!(miri) { 2 } else { native })
}

/// Either side.
pub(crate) fn side() -> impl Strategy<Value = HandSide> {
    prop_oneof![Just(HandSide::Left), Just(HandSide::Right)]
}

/// Fraction of each joint's range, 0 to 1.
pub(crate) fn fractions() -> impl Strategy<Value = [f64; JOINTS]> {
    prop::array::uniform11(0.0..=1.0)
}

/// Joint angles from fractions of the way between the limits.
pub(crate) fn between_limits(hand: &HandModel, fractions: &[f64; JOINTS]) -> HandVector {
    HandVector::from_fn(JOINTS, |index| {
        let joint = &hand.joints()[index];
        joint.lower + (joint.upper - joint.lower) * fractions[index]
    })
}

/// Joint angles written in degrees.
pub(crate) fn degrees(q_deg: [f64; JOINTS]) -> HandVector {
    HandVector::from(q_deg).map(f64::to_radians)
}

/// Fails if two vectors differ by more than `tolerance` in length.
#[track_caller]
pub(crate) fn assert_near(what: &str, is: Vector3<f64>, wanted: Vector3<f64>, tolerance: f64) {
    let off = (is - wanted).norm();
    assert!(
        off <= tolerance,
        "{what}: is {is:?}, wanted {wanted:?}, off by {off:e}"
    );
}
