//! Tests of servo maps: all errors are reported at once, each with its location.

use std::path::Path;

use atas_robots::map::file::MapFile;
use atas_robots::map::{self, Check};
use proptest::prelude::*;

use crate::rig::two_hands;

#[test]
fn valid_map_round_trips() {
    let file = two_hands();
    let text = toml::to_string(&file).unwrap();
    assert_eq!(toml::from_str::<MapFile>(&text).unwrap(), file);
    let map = map::validate(&file, Check::Whole).unwrap();
    assert_eq!((map.joints.len(), map.ports.len()), (22, 2));
}

#[test]
fn shipped_map_is_valid() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("two_hand_arm.toml");
    let map = map::load(&path, Check::Whole).unwrap();
    let families: Vec<_> = map.ports.iter().map(|port| port.driver.name()).collect();
    assert_eq!(families, ["dynamixel", "feetech"]);
}

#[test]
fn all_errors_are_reported_at_once() {
    let mut file = two_hands();
    file.ports[0].baud = 1;
    file.ports[0].rate_hz = f64::NAN;
    let servos = &mut file.ports[0].servos;
    servos[0].joint = "left_tail".to_owned();
    servos[1].id = servos[2].id;
    servos[3].direction = 0;
    servos[4].gear = 0.0;
    servos[5].current_limit_a = Some(40.0);
    servos[6].model = "xx".to_owned();
    servos[7].torque_limit_percent = Some(5.0);
    servos[8].temperature_limit_c = Some(f64::INFINITY);
    servos[9].zero_rad = f64::NAN;
    let right = &mut file.ports[1].servos;
    right[0].joint = "right_shoulder_pitch".to_owned();
    right[2].zero_rad = 0.0;
    right[3].torque_limit_percent = None;
    let findings = map::validate(&file, Check::Whole).unwrap_err();
    for words in [
        "/dev/dynamixel: baud is 1, needs one of",
        "rate_hz is NaN, needs 1 to 10000",
        "servo 1: the robot has no joint \"left_tail\"",
        "id 3 is used twice",
        "servo 4: direction is 0, needs 1 or -1",
        "servo 5: gear is 0, needs",
        "servo 6: current_limit_a is 40, needs",
        "servo 7: model is \"xx\", needs one of xl330-m077",
        "servo 8: xm430-w350 is not limited by torque_limit_percent; give current_limit_a",
        "servo 9: temperature_limit_c is inf",
        "servo 10: zero_rad is NaN",
        "right_shoulder_pitch is already assigned to /dev/feetech, servo 1",
        "the limits of right_elbow_pitch are at",
        "servo 4: torque_limit_percent is missing",
        "no servo for left_shoulder_yaw, right_shoulder_yaw",
    ] {
        let found = findings.iter().any(|finding| finding.contains(words));
        assert!(found, "{words:?} is not in {findings:#?}");
    }
    assert_eq!(findings.len(), 15, "{findings:#?}");
}

#[test]
fn uncalibrated_map_may_have_invalid_zeros() {
    let mut file = two_hands();
    file.ports[1].servos[2].zero_rad = 0.0;
    assert!(map::validate(&file, Check::Uncalibrated).is_ok());
    assert!(map::validate(&file, Check::Whole).is_err());
}

#[test]
fn joint_and_shaft_angles_round_trip() {
    let mut file = two_hands();
    file.ports[0].servos[4].gear = 2.5;
    let map = map::validate(&file, Check::Whole).unwrap();
    for servo in map.ports.iter().flat_map(|port| &port.servos) {
        let (lower, upper) = servo.limits_rad;
        for joint_rad in [lower, 0.0, upper] {
            let back_rad = servo.joint_rad(servo.shaft_rad(joint_rad));
            assert!((back_rad - joint_rad).abs() < 1e-12);
        }
    }
}

proptest! {
    /// Property: any values are accepted or rejected without a panic.
    #[test]
    fn arbitrary_numbers_do_not_panic(
        zero_rad in any::<f64>(),
        gear in any::<f64>(),
        rate_hz in any::<f64>(),
        answer_within_ms in any::<f64>(),
        direction in any::<i8>(),
        id in any::<u8>(),
    ) {
        let mut file = two_hands();
        (file.ports[0].rate_hz, file.ports[0].answer_within_ms) = (rate_hz, answer_within_ms);
        let servo = &mut file.ports[0].servos[0];
        (servo.zero_rad, servo.gear, servo.direction, servo.id) = (zero_rad, gear, direction, id);
        let _ = map::validate(&file, Check::Whole);
    }
}
