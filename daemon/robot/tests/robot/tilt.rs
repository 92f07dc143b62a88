//! Jaws that turn as they close: permitted dome tilt, and errors beyond it.

use nalgebra::Vector3;
use robot_model::{GraspPose, HandModel, HandSide, RobotModel, SHIPPED};

fn angular_jaw() -> HandModel {
    let robot = RobotModel::load(
        include_str!("../robots/angular-jaw.urdf"),
        include_str!("../robots/angular-jaw.toml"),
    );
    *robot.expect("it fits").hand(HandSide::Right)
}

fn at_home(hand: &HandModel, opening_m: f64) -> GraspPose {
    GraspPose::from_above(hand.home_m(), hand.home_yaw_rad(), opening_m)
}

/// Jaws that keep their domes parallel keep the strict limit.
#[test]
fn only_turning_jaws_tilt() {
    for files in SHIPPED {
        let robot = files.load().expect("it ships");
        for side in robot.sides() {
            let hand = robot.hand(side);
            assert!(!hand.domes_tilt(), "{}", files.name);
            assert_eq!(hand.dome_error_max_rad(), 0.0175, "{}", files.name);
        }
    }
    let hand = angular_jaw();
    assert!(hand.domes_tilt());
    // 35° of cap minus 23° of patch at 8 N.
    let bears_deg = hand.dome_error_max_rad().to_degrees();
    assert!((bears_deg - 12.0).abs() < 0.1, "{bears_deg}");
}

/// The jaw grasps in the middle of its range. Too narrow or too wide grasps are rejected with their
/// dome error; open, the jaw reaches them.
#[test]
fn turning_jaw_grasps_within_its_dome_tolerance() {
    let hand = angular_jaw();
    for opening_m in [0.03, 0.04, 0.05, 0.06] {
        let found = hand.contact_posture_for(&at_home(&hand, opening_m));
        let found = found.unwrap_or_else(|error| panic!("{opening_m}: {error}"));
        assert!(found.dome_error_rad < 0.21, "{opening_m}: {found:?}");
    }
    for opening_m in [0.015, 0.075] {
        let frame = at_home(&hand, opening_m);
        let error = hand.contact_posture_for(&frame).expect_err("refused");
        assert!(
            error.to_string().contains("beside the closing axis"),
            "{error}"
        );
        assert!(hand.posture_for(&frame).is_ok() && hand.reaches(&frame));
    }
}

/// The jaw tilts in the plane of its arm, so its closing axis turns only a limited angle from that
/// plane.
#[test]
fn five_joints_do_not_reach_every_yaw() {
    let hand = angular_jaw();
    let reaches = |yaw_deg: f64| {
        let yaw_rad = hand.home_yaw_rad() + yaw_deg.to_radians();
        hand.reaches(&GraspPose::from_above(hand.home_m(), yaw_rad, 0.06))
    };
    assert!(reaches(-20.0) && reaches(0.0) && reaches(20.0));
    assert!(!reaches(80.0) && !reaches(-80.0));
}

/// Regression: four fingertips stacked two by two missed their places by "0.000 mm and 0.00°".
#[test]
fn fingertips_stacked_on_one_side_are_named() {
    let urdf = r#"<robot name="stacked"><link name="base"/><link name="palm"/><link name="a"/><link name="b"/>
      <joint name="stage" type="prismatic"><parent link="base"/><child link="palm"/><origin xyz="0.3 0 0.25"/>
        <axis xyz="0 0 1"/><limit lower="-0.1" upper="0.1" effort="100" velocity="0.2"/></joint>
      <joint name="left" type="prismatic"><parent link="palm"/><child link="a"/><axis xyz="0 1 0"/>
        <limit lower="0" upper="0.08" effort="50" velocity="0.2"/></joint>
      <joint name="right" type="prismatic"><parent link="palm"/><child link="b"/><axis xyz="0 -1 0"/>
        <limit lower="0" upper="0.08" effort="50" velocity="0.2"/><mimic joint="left"/></joint>
      TIPS</robot>"#;
    let mut tips = String::new();
    let mut fingers = String::new();
    for (jaw, side, y) in [("a", 1, 1.0), ("b", 2, -1.0)] {
        for (row, z) in [-0.08, -0.12].iter().enumerate() {
            tips += &format!(
                r#"<link name="{jaw}{row}"/><joint name="{jaw}{row}_fixed" type="fixed"><parent link="{jaw}"/>
                <child link="{jaw}{row}"/><origin xyz="0 {} {z}"/></joint>"#,
                0.02 * y
            );
            fingers += &format!(
                "{{ tip = \"{jaw}{row}\", side = {side}, facing = [0, {}, 0], dome_radius_m = 0.015 }},",
                -y
            );
        }
    }
    let file = format!(
        "[hands.right]\npalm = \"palm\"\ndown = [0, 0, -1]\nfingers = [{fingers}]\n[joints]\n\
         stage = {{ stiffness = 40000, inertia = 2.0 }}\nleft = {{ rest_m = 0.04, stiffness = 20000, inertia = 0.4 }}\n"
    );
    let robot = RobotModel::load(&urdf.replace("TIPS", &tips), &file).expect("it fits");
    let hand = robot.hand(HandSide::Right);
    let frame = at_home(hand, hand.home_opening_m());
    let error = hand.posture_for(&frame).expect_err("refused").to_string();
    let wanted = "one of several fingertips of a side stayed 20.0 mm beside its place";
    assert!(error.contains(wanted), "{error}");
    let far = GraspPose::from_above(Vector3::new(2.0, 0.0, 0.1), 0.0, 0.05);
    let error = hand.posture_for(&far).expect_err("refused").to_string();
    assert!(error.contains("mm off, needs at most"), "{error}");
}

/// At home the closing axis is the base's y, to the last bit, so that rounding turns nothing.
#[test]
fn built_in_robots_close_along_y_at_home() {
    for files in SHIPPED {
        let robot = files.load().expect("it ships");
        for side in robot.sides() {
            let yaw_rad = robot.hand(side).home_yaw_rad();
            assert_eq!(yaw_rad, core::f64::consts::FRAC_PI_2, "{}", files.name);
        }
    }
}
