//! One step of the inverse kinematics: equals the prototype, and is safe for any input.

use nalgebra::Vector3;
use proptest::prelude::*;
use robot_model::{
    FINGERTIPS_MAX, GraspPose, HandSide, HandTarget, HandVector, IkStatus, IkWeights,
};

use crate::support::{JOINTS, ROBOT, between_limits, degrees, fractions, side};

const DT_S: f64 = 1e-3;

struct Row {
    side: HandSide,
    q_deg: [f64; JOINTS],
    tip_m: [[f64; 3]; 2],
    closing_yaw_deg: f64,
    hand_azimuth_deg: f64,
    hand_pitch_deg: f64,
    root_deg: f64,
    dq: [f64; JOINTS],
    status: IkStatus,
    /// Tolerance for held joints: the prototype holds a joint by a penalty of 1e6, this crate
    /// exactly.
    tolerance_rad: f64,
}

/// Steps computed with the Python prototype (numpy).
const PROTOTYPE_STEPS: &[Row] = &[
    Row {
        side: HandSide::Right,
        q_deg: [
            6.69, -14.52, 97.02, 7.84, 36.68, 1.01, -8.71, 38.52, 1.01, -5.93, 36.14,
        ],
        tip_m: [
            [0.334885, -0.154234, 0.049908],
            [0.30539, -0.205433, 0.049899],
        ],
        closing_yaw_deg: 60.0,
        hand_azimuth_deg: 0.0,
        hand_pitch_deg: 90.0,
        root_deg: 0.0,
        dq: [
            0.000440415788206,
            0.000483724561009,
            -0.00084694613782,
            0.000385053301576,
            0.000438863529831,
            0.000169335133884,
            -0.000716432083832,
            0.000699694593009,
            -0.000231723987414,
            -0.000860281541601,
            0.000876273693487,
        ],
        status: IkStatus::Free,
        tolerance_rad: 1e-12,
    },
    Row {
        side: HandSide::Left,
        q_deg: [
            -30.07, 11.8, 80.28, -44.79, 0.0, -27.72, -50.57, 80.54, -27.72, -50.57, 80.54,
        ],
        tip_m: [
            [0.412352, 0.056346, 0.045102],
            [0.347217, -0.056204, 0.045102],
        ],
        closing_yaw_deg: 60.0,
        hand_azimuth_deg: -30.0,
        hand_pitch_deg: 45.0,
        root_deg: -27.5,
        dq: [
            -0.000139316337442,
            -0.00118929029006,
            0.00188671816733,
            -0.000709272959972,
            -7.61473559459e-05,
            0.002121799962,
            -0.00110204220223,
            0.000947011983998,
            0.00206687968228,
            -0.000121413011186,
            0.00027258165235,
        ],
        status: IkStatus::Free,
        tolerance_rad: 1e-12,
    },
    Row {
        side: HandSide::Right, // tips 3.6 mm off: shortened, softened, several joints at their speed limit
        q_deg: [
            30.12, -21.3, 72.98, 38.44, 60.1, 2.71, -8.4, 38.29, -3.71, -6.04, 36.16,
        ],
        tip_m: [
            [0.391611, 0.028994, 0.128009],
            [0.374334, -0.028941, 0.128009],
        ],
        closing_yaw_deg: 60.0,
        hand_azimuth_deg: 0.0,
        hand_pitch_deg: 90.0,
        root_deg: 0.0,
        dq: [
            -0.000994339597678,
            0.002,
            -0.002,
            -0.000592459259923,
            -0.000976362160561,
            -0.005,
            -0.00499999967371,
            0.005,
            -0.005,
            0.00499999960333,
            -0.005,
        ],
        status: IkStatus::AtLimit,
        tolerance_rad: 1e-8,
    },
    Row {
        side: HandSide::Right, // one joint at its speed limit
        q_deg: [
            0.0, -39.5, 123.68, 6.96, 0.0, 2.0, -24.14, 54.14, 2.0, -24.15, 54.14,
        ],
        tip_m: [
            [0.260065, -0.174507, 0.150004],
            [0.260065, -0.264757, 0.150005],
        ],
        closing_yaw_deg: 91.0,
        hand_azimuth_deg: 0.0,
        hand_pitch_deg: 90.0,
        root_deg: 5.0,
        dq: [
            0.00140754990694,
            0.000601355825005,
            -0.002,
            0.001241382554,
            0.000535043432862,
            0.00364671405955,
            -0.00261043001723,
            0.00259533584651,
            0.00429752603144,
            -0.00235964131869,
            0.00237242009407,
        ],
        status: IkStatus::AtLimit,
        tolerance_rad: 1e-8,
    },
];

#[test]
fn steps_equal_the_prototype() {
    for row in PROTOTYPE_STEPS {
        let hand = ROBOT.hand(row.side);
        let mut grasp =
            GraspPose::from_above(Vector3::zeros(), row.closing_yaw_deg.to_radians(), 0.0);
        grasp.hand_azimuth_rad = row.hand_azimuth_deg.to_radians();
        grasp.hand_pitch_rad = row.hand_pitch_deg.to_radians();
        grasp.root_rad = row.root_deg.to_radians();
        let mut target = grasp.target(hand);
        for (tip_m, wanted_m) in target.tip_m.iter_mut().zip(row.tip_m) {
            *tip_m = Vector3::from(wanted_m);
        }
        let pose = hand.forward(&degrees(row.q_deg));
        let step = hand.ik_step(
            &pose,
            &hand.jacobian(&pose),
            &target,
            DT_S,
            &IkWeights::TICK,
        );
        let off = (step.dq - HandVector::from(row.dq)).amax();
        assert!(
            off <= row.tolerance_rad,
            "{:?} off by {off:e}: {:?}",
            row.side,
            step.dq
        );
        assert_eq!(step.status, row.status);
    }
}

/// Any number: mostly ordinary ones, sometimes others (infinities, NaN, subnormals, huge).
fn any_number() -> impl Strategy<Value = f64> {
    prop_oneof![8 => -1.0..1.0_f64, 1 => any::<f64>(), 1 => prop::num::f64::ANY]
}

fn any_vector() -> impl Strategy<Value = Vector3<f64>> {
    prop::array::uniform3(any_number()).prop_map(Vector3::from)
}

fn any_target() -> impl Strategy<Value = HandTarget> {
    let tips = || prop::array::uniform::<_, FINGERTIPS_MAX>(any_vector());
    (tips(), tips(), any_vector(), any_number()).prop_map(
        |(tip_m, dome_axis, hand_axis, root_rad)| HandTarget {
            tip_m,
            dome_axis,
            hand_axis,
            root_rad,
        },
    )
}

proptest! {
    #![proptest_config(crate::support::cases(2000))]

    #[test]
    fn any_target_keeps_limits_and_speeds(side in side(), fractions in fractions(), target in any_target()) {
        let hand = ROBOT.hand(side);
        let mut q = between_limits(hand, &fractions);
        for _ in 0..5 {
            let pose = hand.forward(&q);
            let step = hand.ik_step(&pose, &hand.jacobian(&pose), &target, DT_S, &IkWeights::TICK);
            prop_assert!(hand.within_limits(&step.q), "left the limits: {:?}", step.q);
            for (dq, joint) in step.dq.iter().zip(hand.joints()) {
                prop_assert!(dq.abs() <= joint.velocity_max * DT_S + 1e-15, "{} moved {dq}", joint.name);
            }
            prop_assert!(target.is_finite() || step.status == IkStatus::Failed);
            prop_assert!(!step.tip_error_m.is_nan());
            q = step.q;
        }
    }

    #[test]
    fn any_angles_and_any_time_give_a_finite_step(
        q in prop::array::uniform11(any_number()),
        dt_s in any_number(),
        target in any_target(),
    ) {
        let hand = ROBOT.hand(HandSide::Right);
        let pose = hand.forward(&HandVector::from(q));
        let step = hand.ik_step(&pose, &hand.jacobian(&pose), &target, dt_s, &IkWeights::TICK);
        prop_assert!(step.dq.iter().all(|dq| dq.is_finite()));
        if step.status == IkStatus::Failed {
            prop_assert_eq!(step.dq, HandVector::zeros(JOINTS));
        }
    }
}

#[test]
fn joint_outside_its_limits_returns_at_its_speed_limit() {
    let hand = ROBOT.hand(HandSide::Left);
    let target = GraspPose::from_above(Vector3::new(0.3, 0.2, 0.1), 1.5, 0.06).target(hand);
    let mut q = *hand.reference();
    q[7] = hand.joints()[7].upper + 0.02;
    for tick in 0..10 {
        let pose = hand.forward(&q);
        let step = hand.ik_step(
            &pose,
            &hand.jacobian(&pose),
            &target,
            DT_S,
            &IkWeights::TICK,
        );
        let speed_limit = hand.joints()[7].velocity_max * DT_S;
        assert!(
            step.dq[7] < 0.0 && step.dq[7] >= -speed_limit * (1.0 + 1e-12),
            "tick {tick}"
        );
        q = step.q;
    }
    assert!(hand.within_limits(&q));
}
