//! URDF loader: accepted robots, and errors of rejected ones.

use nalgebra::Vector3;
use robot_model::{
    CAPSULES_MAX, Capsule, HandSide, ModelError, RobotFiles, RobotModel, SHIPPED, TWO_HAND_ARM,
    clearance_m,
};

use crate::support::ROBOT;

/// Loads the two-hand arm with another URDF.
fn with_urdf(urdf: &str) -> Result<RobotModel, ModelError> {
    RobotModel::load(urdf, &TWO_HAND_ARM.robot_file)
}

/// Loads the built-in URDF with the first `from` replaced by `to` and compares the error.
#[track_caller]
fn check(from: &str, to: &str, wanted: &str) {
    assert!(TWO_HAND_ARM.urdf.contains(from), "the URDF has no {from}");
    let error = with_urdf(&TWO_HAND_ARM.urdf.replacen(from, to, 1))
        .expect_err("refused")
        .to_string();
    assert!(error.contains(wanted), "said: {error}\nlacks: {wanted}");
}

const ELBOW: &str =
    r#"<axis xyz="0 1 0"/><limit lower="0.0873" upper="2.618" effort="30" velocity="2"/>"#;

#[test]
fn invalid_number_is_named() {
    let elbow = |axis: &str, lower: &str, upper: &str, effort: &str, velocity: &str| {
        format!(
            r#"<axis xyz="{axis}"/><limit lower="{lower}" upper="{upper}" effort="{effort}" velocity="{velocity}"/>"#
        )
    };
    for (replaced, wanted) in [
        (
            elbow("0 1 0", "2.7", "2.618", "30", "2"),
            "the limit of joint `left_elbow_pitch` was 2.7 to 2.618, needs a finite lower",
        ),
        (elbow("0 1 0", "1", "1", "30", "2"), "was 1 to 1, needs"),
        (
            elbow("0 1 0", "NaN", "2.618", "30", "2"),
            "was NaN to 2.618, needs",
        ),
        (elbow("0 1 0", "0", "inf", "30", "2"), "was 0 to inf, needs"),
        (
            elbow("0 1 0", "0", "1", "30", "0"),
            "the velocity of joint `left_elbow_pitch` was 0, needs finite and above 0",
        ),
        (
            elbow("0 1 0", "0", "1", "30", "-2"),
            "was -2, needs finite and above 0",
        ),
        (
            elbow("0 1 0", "0", "1", "30", "NaN"),
            "was NaN, needs finite and above 0",
        ),
        (
            elbow("0 1 0", "0", "1", "-1", "2"),
            "the effort of joint `left_elbow_pitch` was -1",
        ),
        (
            elbow("0 2 0", "0", "1", "30", "2"),
            "the axis of joint `left_elbow_pitch` was (0, 2, 0) of length 2, needs a unit vector",
        ),
        (elbow("0 0 0", "0", "1", "30", "2"), "of length 0"),
        (elbow("0 NaN 0", "0", "1", "30", "2"), "of length NaN"),
    ] {
        check(ELBOW, &replaced, wanted);
    }
    check(
        r#"xyz="0 0.22 0.34""#,
        r#"xyz="0 inf 0.34""#,
        "the origin of joint `left_shoulder_yaw` was xyz [0.0, inf, 0.34]",
    );
}

#[test]
fn invalid_structure_is_named() {
    for (from, to, wanted) in [
        (
            r#"<joint name="left_elbow_pitch""#,
            r#"<joint name="left_elbow""#,
            "joint `left_elbow_pitch` was missing",
        ),
        (
            r#"<joint name="left_elbow_pitch" type="revolute">"#,
            r#"<joint name="left_elbow_pitch" type="fixed">"#,
            "the type of joint `left_elbow_pitch` was fixed, needs a moving joint",
        ),
        (
            r#"<joint name="left_elbow_pitch" type="revolute">"#,
            r#"<joint name="left_elbow_pitch" type="prismatic">"#,
            "the rest of joint `left_elbow_pitch` was in the other unit, needs `rest_m`",
        ),
        (
            r#"<joint name="left_elbow_pitch" type="revolute">"#,
            r#"<joint name="left_elbow_pitch" type="floating">"#,
            "was Floating, needs",
        ),
        (
            ELBOW,
            &format!(r#"{ELBOW}<mimic joint="left_wrist_pitch"/>"#),
            "joint `left_elbow_pitch` of the arm was a mimic joint, needs",
        ),
        (
            r#"<link name="left_finger1_tip">"#,
            r#"<link name="left_thumb_tip">"#,
            "link `left_finger1_tip` was missing",
        ),
        (
            r#"<child link="left_finger1_tip"/>"#,
            r#"<child link="left_finger2_tip"/>"#,
            "link `left_finger2_tip` was the child of joints",
        ),
        (
            r#"<child link="left_finger1_proximal"/>"#,
            r#"<child link="left_finger9_proximal"/>"#,
            "fingertip `left_finger1_tip` was not carried by palm `left_hand`",
        ),
        (
            r#"<parent link="left_hand"/>"#,
            r#"<parent link="right_hand"/>"#,
            "fingertip `left_finger1_tip` was not carried by palm `left_hand`",
        ),
        (
            r#"<parent link="left_hand"/>"#,
            r#"<parent link="left_palm"/>"#,
            "link `left_palm` was missing",
        ),
        (
            r#"<parent link="base"/>"#,
            r#"<parent link="torso"/>"#,
            "was fixed to itself in a loop",
        ),
        (
            r#"<sphere radius="0.015"/></geometry></collision>"#,
            r#"<box size="1 1 1"/></geometry></collision>"#,
            "the collision of link `left_finger1_tip` was spheres of radius []",
        ),
        (
            r#"<sphere radius="0.015"/></geometry></collision>"#,
            r#"<sphere radius="-1"/></geometry></collision>"#,
            "spheres of radius [-1.0], needs exactly one",
        ),
        (
            r#"<cylinder radius="0.033" length="0.25"/></geometry></collision>"#,
            r#"<mesh filename="arm.stl"/></geometry></collision>"#,
            "the collision of link `left_forearm` was a mesh",
        ),
        (
            r#"<cylinder radius="0.033" length="0.25"/></geometry></collision>"#,
            r#"<box size="0 0 NaN"/></geometry></collision>"#,
            "the collision of link `left_forearm` was radius 0",
        ),
        (
            r#"<cylinder radius="0.033" length="0.25"/></geometry></collision>"#,
            r#"<cylinder radius="0" length="NaN"/></geometry></collision>"#,
            "was radius 0, length NaN",
        ),
    ] {
        check(from, to, wanted);
    }
}

#[test]
fn text_without_urdf_is_rejected() {
    for text in [
        "",
        "not xml",
        "<robot",
        "<robot name=\"empty\"/>",
        "<html></html>",
    ] {
        let error = with_urdf(text).expect_err("refused").to_string();
        assert!(
            error.starts_with("could not load the robot because"),
            "{text:?}: {error}"
        );
    }
}

/// Regression: hands whose fingers have eight collision boxes each were rejected.
#[test]
fn excess_collision_shapes_are_merged() {
    let ball = |z_m: f64| {
        format!(
            r#"<collision><origin xyz="0.01 0 {z_m}"/><geometry><sphere radius="0.01"/></geometry></collision>"#
        )
    };
    let heights_m: Vec<f64> = (0..20).map(|ball| 0.004 * f64::from(ball)).collect();
    let hand = r#"<link name="left_hand">"#;
    let balls: String = heights_m.iter().map(|z_m| ball(*z_m)).collect();
    let robot =
        with_urdf(&TWO_HAND_ARM.urdf.replace(hand, &format!("{hand}{balls}"))).expect("it loads");
    let left = robot.hand(HandSide::Left);
    let pose = left.forward(left.reference());
    let bodies = left.capsules(&pose);
    assert_eq!(bodies.len(), CAPSULES_MAX);
    for z_m in heights_m {
        let centre_m = pose.base_from_hand().point(&Vector3::new(0.01, 0.0, z_m));
        let ball = Capsule {
            a_m: centre_m,
            b_m: centre_m,
            radius_m: 0.0,
            joint: 0,
        };
        let depth_m = -clearance_m(&[ball], &bodies);
        assert!(depth_m > 0.01 - 1e-9, "{z_m}: {depth_m}");
    }
}

#[test]
fn missing_file_is_named() {
    let check = |robot: &str, part: &str| {
        let error = RobotModel::find(robot)
            .expect_err("no such robot")
            .to_string();
        assert!(error.contains(part), "{error}");
    };
    check("/nowhere/robot.toml", "/nowhere/robot.toml was unreadable");
    check(
        "/nowhere/robot.urdf",
        "needs a robot file (.toml) that names this URDF",
    );
    check(
        "two-hand-arn",
        "needs one of two-hand-arm, arm7-gripper, three-finger, test-bench",
    );
}

#[test]
fn a_file_gives_the_same_robot_as_its_text() {
    for shipped in SHIPPED {
        let (folder, name) = (env!("CARGO_MANIFEST_DIR"), &shipped.name);
        let read =
            RobotFiles::find(&format!("{folder}/robots/{name}/robot.toml")).expect("readable");
        assert_eq!(
            (&read.urdf, &read.robot_file),
            (&shipped.urdf, &shipped.robot_file)
        );
        assert_eq!(
            RobotModel::find(name).expect("it ships"),
            read.load().expect("it ships")
        );
    }
    assert_eq!(TWO_HAND_ARM.load().expect("it ships"), *ROBOT);
}

#[test]
fn limits_come_from_the_file() {
    let text = TWO_HAND_ARM.urdf.replacen(
        ELBOW,
        &ELBOW.replace("2.618", "1.2").replace("0.0873", "0.2"),
        1,
    );
    let robot = with_urdf(&text).expect("other limits fit");
    let hand = robot.hand(HandSide::Left);
    assert_eq!((hand.joints()[2].lower, hand.joints()[2].upper), (0.2, 1.2));
    assert_eq!(
        hand.reference()[2],
        1.2,
        "the reference posture moves inside the limits"
    );
}

/// Every problem has its file and line.
#[test]
fn problem_has_file_and_line() {
    let line_of = |text: &str, part: &str| {
        let lines = text.lines().position(|line| line.contains(part));
        lines.expect("it is there") + 1
    };
    let urdf = TWO_HAND_ARM.urdf.replacen(
        ELBOW,
        r#"<axis xyz="0 2 0"/><limit lower="0" upper="1" effort="1" velocity="1"/>"#,
        1,
    );
    let joint = "left_wrist_roll = { rest_deg = 0, stiffness = 512";
    let file = TWO_HAND_ARM
        .robot_file
        .replace(joint, "left_wrist_roll = { rest_deg = 0, stiffness = -512");
    let error = RobotModel::load(&urdf, &file).expect_err("refused");
    let ModelError::Problems(problems) = &error else {
        panic!("{error}");
    };
    assert_eq!(problems.len(), 2, "{error}");
    let places = [
        format!(
            "line {} of the URDF",
            line_of(&urdf, "name=\"left_elbow_pitch\"")
        ),
        format!(
            "line {} of the robot file",
            line_of(&file, "left_wrist_roll")
        ),
    ];
    for place in places {
        assert!(
            error.to_string().contains(&place),
            "{error}\nlacks: {place}"
        );
    }
}

/// Two arms must keep apart, so all meshes are rejected at once. A single hand ignores them and
/// reports this.
#[test]
fn meshes_are_rejected_or_reported_as_ignored() {
    let mesh = r#"<geometry><mesh filename="part.stl"/></geometry></collision>"#;
    let end = "</geometry></collision>";
    let with_meshes = |urdf: &str| {
        let shapes = urdf.split(end).collect::<Vec<_>>();
        let (last, all) = shapes.split_last().expect("shapes");
        let all = all.iter().map(|text| {
            let (before, _) = text.rsplit_once("<geometry>").expect("a shape");
            format!("{before}{mesh}")
        });
        all.collect::<String>() + last
    };
    let error = with_urdf(&with_meshes(&TWO_HAND_ARM.urdf)).expect_err("refused");
    let ModelError::Problems(problems) = &error else {
        panic!("{error}");
    };
    let meshes = problems.iter().filter(|problem| problem.was == "a mesh");
    assert!(meshes.count() > 10, "{error}");
    let bench = RobotFiles::find("test-bench").expect("it ships");
    let urdf = with_meshes(&bench.urdf);
    // The radius of the dome comes from its collision sphere.
    let file = bench
        .robot_file
        .replace("side = 1 }", "side = 1, dome_radius_m = 0.015 }")
        .replace("side = 2 }", "side = 2, dome_radius_m = 0.015 }");
    let alone = RobotFiles {
        urdf: urdf.into(),
        robot_file: file.into(),
        ..bench
    };
    alone.load().expect("a hand alone");
    let remarks = alone.remarks().expect("understood");
    let is_mesh = |remark: &String| remark.starts_with("mesh in the collision");
    assert!(
        remarks.iter().filter(|remark| is_mesh(remark)).count() >= 4,
        "{remarks:?}"
    );
}

#[test]
fn error_names_the_line_of_its_joint_in_either_quotes() {
    let urdf = TWO_HAND_ARM
        .urdf
        .replacen(ELBOW, &ELBOW.replace("0 1 0", "0 2 0"), 1);
    let joint = "<joint name=\"left_elbow_pitch\"";
    // A link of the same name before it is not the joint.
    let urdf = urdf.replacen("<link ", "<link name=\"left_elbow_pitch\"/>\n<link ", 1);
    let line = urdf[..urdf.find(joint).expect("the joint")]
        .matches('\n')
        .count()
        + 1;
    let wanted = format!("length 2, needs a unit vector; change line {line} of the URDF");
    for urdf in [urdf.replace('"', "'"), urdf] {
        let error = with_urdf(&urdf).expect_err("refused").to_string();
        assert!(error.contains(&wanted), "said: {error}\nlacks: {wanted}");
    }
}

#[test]
fn text_in_place_of_a_number_is_named_with_its_cure() {
    for (value, cure) in [
        ("${pi/2}", "expand the file with `xacro` first"),
        ("2,618", "numbers with a decimal point, separated by spaces"),
        ("wide", "needs numbers"),
    ] {
        let bad = ELBOW.replace("2.618", value);
        check(
            ELBOW,
            &bad,
            &format!("attribute upper was {value:?}, needs numbers"),
        );
        check(ELBOW, &bad, cure);
        check(ELBOW, &bad, "change line ");
    }
}

#[test]
fn long_chain_of_fixed_links_is_loaded_or_refused_by_its_number() {
    let chain = |count: usize| {
        let link = |n: usize| format!("<link name=\"tail{n}\"/>\n");
        let joint = |n: usize| {
            let parent = if n == 0 {
                "base".to_owned()
            } else {
                format!("tail{}", n - 1)
            };
            format!(
                "<joint name=\"tail{n}\" type=\"fixed\"><parent link=\"{parent}\"/><child link=\"tail{n}\"/></joint>\n"
            )
        };
        let parts: String = (0..count).map(|n| link(n) + &joint(n)).collect();
        TWO_HAND_ARM
            .urdf
            .replacen("</robot>", &(parts + "</robot>"), 1)
    };
    with_urdf(&chain(1900)).expect("loaded");
    let error = with_urdf(&chain(10_000)).expect_err("refused").to_string();
    assert!(error.contains("the number of links was 100"), "{error}");
    assert!(error.contains("needs at most 2000"), "{error}");
}
