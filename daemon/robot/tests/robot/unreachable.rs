//! Targets out of reach: the hand stops as near as possible, without chatter.

use nalgebra::Vector3;
use robot_model::{GraspPose, HandSide, HandVector, IkStatus, IkWeights};

use crate::support::ROBOT;

const DT_S: f64 = 1e-3;
const TICKS: usize = 3000;
/// Final period in which the hand must be at rest.
const REST_TICKS: usize = 300;
/// Fastest joint at rest, as a fraction of its speed limit.
const REST_SPEED_MAX: f64 = 0.05;

/// Runs towards a grasp from the cap pose and returns tip error (m) and fastest joint (fraction of
/// its limit) at the end.
fn run(centre_m: [f64; 3], opening_m: f64) -> (f64, f64) {
    let hand = ROBOT.hand(HandSide::Right);
    let start = GraspPose::from_above(Vector3::new(0.38, 0.0, 0.13), 60_f64.to_radians(), 0.0348);
    let mut q = hand.posture_for(&start).expect("the start is reachable").q;
    let wanted =
        GraspPose::from_above(Vector3::from(centre_m), 60_f64.to_radians(), opening_m).target(hand);
    let (mut error_m, mut fastest) = (0.0, 0.0_f64);
    for tick in 0..TICKS {
        let pose = hand.forward(&q);
        let step = hand.ik_step(
            &pose,
            &hand.jacobian(&pose),
            &wanted,
            DT_S,
            &IkWeights::TICK,
        );
        assert_ne!(step.status, IkStatus::Failed, "tick {tick}");
        assert!(hand.within_limits(&step.q), "tick {tick}");
        let share = |dq: &HandVector| {
            dq.iter()
                .zip(hand.joints())
                .fold(0.0_f64, |most, (dq, joint)| {
                    most.max(dq.abs() / (joint.velocity_max * DT_S))
                })
        };
        assert!(share(&step.dq) <= 1.0 + 1e-12, "tick {tick}");
        if tick + REST_TICKS >= TICKS {
            fastest = fastest.max(share(&step.dq));
        }
        (error_m, q) = (step.tip_error_m, step.q);
    }
    (error_m, fastest)
}

#[test]
fn out_of_reach_the_hand_comes_to_rest() {
    for (what, centre_m, opening_m) in [
        ("too far", [0.75, -0.1, 0.1], 0.0348),
        ("a little too far", [0.55, 0.0, 0.05], 0.0348),
        ("under the table", [0.38, 0.0, -0.3], 0.0348),
        ("behind the robot", [-0.4, -0.3, 0.2], 0.0348),
        ("too wide", [0.38, 0.0, 0.13], 0.4),
    ] {
        let (error_m, fastest) = run(centre_m, opening_m);
        assert!(error_m > 1e-3, "{what}: was reached");
        assert!(
            fastest <= REST_SPEED_MAX,
            "{what}: still moves at {fastest} of the speed limit"
        );
    }
}

#[test]
fn reachable_jump_is_tracked_to_the_end() {
    let (error_m, fastest) = run([0.41, 0.02, 0.16], 0.0348);
    assert!(
        error_m < 1e-7 && fastest < 0.01,
        "{error_m:e} m off, {fastest} of the speed limit"
    );
}
