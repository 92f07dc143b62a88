//! Kinematics under a gate that refuses.

use crate::support::{hand_of, home_rad, robot};
use atas_core::arbitration::Intent;
use atas_core::kinematics::HandServo;
use atas_core::modules::Verdict;
use atas_core::perception::Percept;
use robot_model::{Side, VIRTUAL_FINGERS};

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
        finding: atas_core::modules::Finding::default(),
    };
    for _ in 0..2000 {
        let _refused = servo.follow(hand, &closing, &Percept::default(), 1e-3);
    }
    for (now_m, open_m) in servo.frame().half_opening_m.iter().zip(open_m) {
        let ahead_m = open_m - now_m;
        assert!((0.0004..=0.000_51).contains(&ahead_m), "{ahead_m} m");
    }
}
