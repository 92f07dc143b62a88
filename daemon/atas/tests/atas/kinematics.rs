//! Kinematics with a gate that refuses, and with a shared finger drive.

use crate::support::{hand_of, home, robot};
use atas_core::arbitration::Intent;
use atas_core::held_object::LiftFinding;
use atas_core::kinematics::HandServo;
use atas_core::modules::PoseCommand;
use atas_core::modules::Verdict;
use atas_core::perception::Percept;
use robot_model::{GraspPose, GraspSide, HandSide, PerSide, RobotModel};

#[test]
fn refused_closing_does_not_wind_up() {
    let hand = robot().hand(HandSide::Right);
    let q = hand_of(&home(), HandSide::Right);
    let mut servo = HandServo::new(hand, q);
    let open_m = servo.pose().half_opening_m;
    let closing = Intent {
        pose: None,
        closing_m_s: PerSide::repeat(0.002),
        verdict: Verdict::None,
        finding: LiftFinding::None,
    };
    for _ in 0..2000 {
        let _refused = servo.update(hand, &closing, &Percept::default(), 1e-3);
    }
    for (now_m, open_m) in servo.pose().half_opening_m.iter().zip(open_m) {
        let ahead_m = open_m - now_m;
        assert!((0.0004..=0.000_51).contains(&ahead_m), "{ahead_m} m");
    }
}

/// Regression: the jaws share a drive, and a request opened one by more than it closed the other.
/// The gate took the resulting closing for opening, at twice the grip ceiling.
#[test]
fn shared_drive_closing_is_not_reported_as_opening() {
    let robot = RobotModel::find("arm7-gripper").expect("a built-in robot");
    let hand = robot.hand(HandSide::Right);
    let home = GraspPose::from_above(hand.home_m(), hand.home_yaw_rad(), hand.home_opening_m());
    let q = hand.posture_for(&home).expect("a reachable posture").q;
    let output = |by_m: PerSide<f64>| {
        let mut servo = HandServo::new(hand, q);
        let mut frame = *servo.pose();
        for (half_m, by_m) in frame.half_opening_m.iter_mut().zip(by_m) {
            *half_m -= by_m;
        }
        let intent = Intent {
            pose: Some(PoseCommand {
                pose: frame,
                with_fingers: true,
                arrived: false,
            }),
            closing_m_s: PerSide::repeat(0.0),
            verdict: Verdict::None,
            finding: LiftFinding::None,
        };
        servo.update(hand, &intent, &Percept::default(), 1e-3)
    };
    // Both close by the difference between closing and opening.
    let command = output([-1e-6, 3e-6].into());
    assert!(command.closing_m_s().iter().all(|closing| *closing > 0.0));
    let command = output([-3e-6, 1e-6].into());
    assert!(
        command.closing_m_s()[GraspSide::First] < 0.0
            && command.closing_m_s()[GraspSide::Second] > 0.0
    );
    let command = output(PerSide::repeat(-1e-6));
    assert!(command.closing_m_s().iter().all(|closing| *closing < 0.0));
}

/// Regression: a hand with two fingertips on one side tilts against its commanded direction, because
/// the fingertips have priority. A restarted daemon took the tilt for the command and moved the
/// fingertips by 0.6 mm at once; the object slid by 6 mm.
#[test]
fn synchronised_hand_leaves_its_fingertips_where_they_are() {
    for name in ["two-hand-arm", "three-finger", "arm7-gripper"] {
        let robot = RobotModel::find(name).expect("a built-in robot");
        let hand = robot.hand(HandSide::Right);
        let home = GraspPose::from_above(hand.home_m(), hand.home_yaw_rad(), hand.home_opening_m());
        let q = hand.posture_for(&home).expect("a reachable posture").q;
        for joint in hand.arm_joints() {
            let mut tilted = q;
            tilted[joint] += 0.03;
            let (pose, servo) = (hand.forward(&tilted), HandServo::new(hand, tilted));
            let target = servo.pose().target(hand);
            for finger in 0..hand.fingertip_count() {
                let off_m = (target.tip_m[finger] - pose.tip_m(finger)).norm();
                assert!(
                    off_m < 3e-5,
                    "{name}, joint {joint}, tip {finger}: {off_m} m"
                );
            }
        }
    }
}
