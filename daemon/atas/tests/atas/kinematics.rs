//! Kinematics with a gate that refuses, and with a shared finger drive.

use crate::support::{hand_of, home_rad, robot};
use atas_core::arbitration::Intent;
use atas_core::kinematics::HandServo;
use atas_core::modules::Verdict;
use atas_core::modules::{Finding, PoseCommand};
use atas_core::perception::Percept;
use robot_model::{GraspFrame, RobotModel, Side, VIRTUAL_FINGERS};

#[test]
fn closing_that_the_gate_refuses_does_not_pile_up() {
    let hand = robot().hand(Side::Right);
    let q_rad = hand_of(&home_rad(), Side::Right);
    let mut servo = HandServo::at(hand, q_rad);
    let open_m = servo.frame().half_opening_m;
    let closing = Intent {
        pose: None,
        closing_m_s: [0.002; VIRTUAL_FINGERS],
        verdict: Verdict::None,
        finding: Finding::default(),
    };
    for _ in 0..2000 {
        let _refused = servo.follow(hand, &closing, &Percept::default(), 1e-3);
    }
    for (now_m, open_m) in servo.frame().half_opening_m.iter().zip(open_m) {
        let ahead_m = open_m - now_m;
        assert!((0.0004..=0.000_51).contains(&ahead_m), "{ahead_m} m");
    }
}

/// Regression: the jaws share a drive, and a request opened one by more than it closed the other.
/// The gate took the resulting closing for opening, at twice the grip ceiling.
#[test]
fn a_jaw_that_its_drive_closes_does_not_open() {
    let robot = RobotModel::find("arm7-gripper").expect("it ships");
    let hand = robot.hand(Side::Right);
    let home = GraspFrame::from_above(hand.home_m(), hand.home_yaw_rad(), hand.home_opening_m());
    let q_rad = hand.posture_for(&home).expect("it rests there").q_rad;
    let told = |by_m: [f64; VIRTUAL_FINGERS]| {
        let mut servo = HandServo::at(hand, q_rad);
        let mut frame = *servo.frame();
        for (half_m, by_m) in frame.half_opening_m.iter_mut().zip(by_m) {
            *half_m -= by_m;
        }
        let intent = Intent {
            pose: Some(PoseCommand {
                frame,
                with_fingers: true,
                arrived: false,
            }),
            closing_m_s: [0.0; VIRTUAL_FINGERS],
            verdict: Verdict::None,
            finding: Finding::default(),
        };
        servo.follow(hand, &intent, &Percept::default(), 1e-3)
    };
    // Both close by the difference between closing and opening.
    let command = told([-1e-6, 3e-6]);
    assert!(command.closing_m_s().iter().all(|closing| *closing > 0.0));
    let command = told([-3e-6, 1e-6]);
    assert!(command.closing_m_s()[0] < 0.0 && command.closing_m_s()[1] > 0.0);
    let command = told([-1e-6; VIRTUAL_FINGERS]);
    assert!(command.closing_m_s().iter().all(|closing| *closing < 0.0));
}
