//! Files of users: configuration, tasks, tables, robots, objects, sensors, servos, targets.
//!
//! An input is the text of a file. Text that is not UTF-8 is rejected before the parsers, so an
//! input is converted first.

use robot_model::{GraspSide, RobotFile, RobotModel, SHIPPED, Skeleton};
use std::path::Path;

use atas_live::requests::count_targets;
use atas_robots::map::{Check, file::MapFile, validate};
use atas_sensors::calibration::Calibration;
use atas_sensors::plan::Plan;
use atasd::config::Config;
use ebts::course::table_file::CourseFile;
use ebts::evaluate::GoalPoints;
use ebts::genome::Genome;
use ebts::grasp::course;
use ebts::grasp::table_file::GraspFile;
use ebts::table_file::{Hash, TableFile};
use field::{Model, Preset};
use sim_backend::{Object, SensorModel};

use crate::target::Target;

/// Longest text, bytes.
const TEXT: usize = 16 << 10;

/// Targets of this file.
pub(crate) const TARGETS: [Target; 14] = [
    Target::new("configuration", configuration, configuration_seeds).length(TEXT),
    Target::new("task-file", configuration, task_seeds).length(TEXT),
    Target::new("robot-file", robot_file, robot_file_seeds).length(TEXT),
    Target::new("urdf", urdf, urdf_seeds)
        .length(4 * TEXT)
        .executions(300),
    Target::new("object", object, object_seeds),
    Target::new("sensor-model", sensor_model, sensor_model_seeds).length(TEXT),
    Target::new("preset", preset, preset_seeds),
    Target::new("behaviour-table", behaviour_table, behaviour_seeds).length(TEXT),
    Target::new("course-table", course_table, course_seeds),
    Target::new("grasp-table", grasp_table, grasp_seeds),
    Target::new("servo-map", servo_map, servo_map_seeds)
        .length(TEXT)
        .executions(500),
    Target::new("hand-file", hand_file, hand_file_seeds).executions(300),
    Target::new("calibration", calibration, calibration_seeds),
    Target::new("teleop-file", teleop_file, teleop_seeds),
];

/// Separates URDF and robot file in one input.
const SEPARATOR: &str = "\n---\n";

fn texts(texts: impl IntoIterator<Item = impl AsRef<str>>) -> Vec<Vec<u8>> {
    texts
        .into_iter()
        .map(|text| text.as_ref().as_bytes().to_vec())
        .collect()
}

fn configuration(bytes: &[u8]) {
    let text = String::from_utf8_lossy(bytes);
    match Config::parse(Path::new("fuzz.toml"), &text) {
        Ok(config) => {
            // The effective configuration reads back.
            let again = Config::parse(Path::new("again.toml"), &config.text());
            let again = again.expect("the text of a configuration is a configuration");
            assert_eq!(config.hash(), again.hash());
        }
        Err(error) => assert!(!error.to_string().is_empty()),
    }
}

fn configuration_seeds() -> Vec<Vec<u8>> {
    texts([
        include_str!("../../../daemon/atas.example.toml"),
        "[grasp]\ndr_n = 0.1\n[hands.left]\nrate_hz = 500.0\nfingers = 3\n",
        "realtime.cpu = 3\nrealtime.rate_hz = 500\naccess.group = \"command\"\n",
        "[hands.left.layout]\nnormal = [[0,0,1]]\ntangent1 = [[1,0,0]]\ntangent2 = [[0,1,0]]\nposition_m = [[0,0,0]]\nelement_area_m2 = 1e-5\n",
        "hands.right.layout = \"flat-4x4-4.5\"\nrobot.model = \"arm7-gripper\"\n",
    ])
}

fn task_seeds() -> Vec<Vec<u8>> {
    texts([
        "[tasks.polish]\nacting = [\n { step = \"reach\", motion = \"reach\", waypoint = \"before-source\", modules = [\"carry\", \"contact guard\"], transition = \"arrived\", timeout_s = 20.0 },\n { step = \"home\", motion = \"reach\", waypoint = \"home\", modules = [\"carry\"], transition = \"arrived\", timeout_s = 20.0 },\n]\n",
        "[tasks.evolved]\nacting = [\n { step = \"approach\", motion = \"stay\", modules = [\"first touch\"], transition = \"all-touched\", timeout_s = 20.0 },\n { step = \"hold\", motion = \"stay\", modules = [\"behaviour table\"], transition = \"held\" },\n]\ntable = { bits = [\"slip\", \"contact\"], fingers_m_s = [0.0, -0.001, 0.002], hand = [0.0, 1.0], rows = \"00 10 20 21\", hash = \"0000000000000000\" }\n",
        "[tasks.pair]\nacting = [ { step = \"meet\", motion = \"stay\", transition = \"met\", point = 1 } ]\nhelping = [ { step = \"meet\", motion = \"stay\", transition = \"met\", point = 1 } ]\n",
    ])
}

fn robot_file(bytes: &[u8]) {
    let text = String::from_utf8_lossy(bytes);
    if let Err(errors) = RobotFile::parse(&text) {
        assert!(!errors.to_string().is_empty());
    }
}

fn robot_file_seeds() -> Vec<Vec<u8>> {
    texts(SHIPPED.iter().map(|files| &files.robot_file))
}

fn urdf(bytes: &[u8]) {
    let text = String::from_utf8_lossy(bytes);
    let (urdf, robot_file) = text.split_once(SEPARATOR).unwrap_or((&text, ""));
    match RobotModel::load(urdf, robot_file) {
        Ok(robot) => {
            for side in robot.sides() {
                let hand = robot.hand(side);
                let pose = hand.forward(&robot_model::HandVector::from_slice(hand.reference()));
                assert!(
                    pose.side_m(GraspSide::First)
                        .iter()
                        .all(|value| value.is_finite())
                );
            }
        }
        Err(error) => assert!(!error.to_string().is_empty()),
    }
    let _drawn = Skeleton::read(urdf, vec!["grip".to_owned()]);
}

fn urdf_seeds() -> Vec<Vec<u8>> {
    let mut seeds = vec![format!("{PRESS_URDF}{SEPARATOR}{PRESS}")];
    seeds.extend(
        SHIPPED
            .iter()
            .map(|files| format!("{}{SEPARATOR}{}", files.urdf, files.robot_file)),
    );
    // Small robots reach more of the reader in the same time.
    seeds.extend(vec![seeds[0].clone(); 12]);
    texts(seeds)
}

const PRESS_URDF: &str = r#"<robot name="press">
<link name="base"><collision><geometry><box size="0.1 0.1 0.1"/></geometry></collision></link><link name="head"><collision><origin xyz="0 0 0.1" rpy="0 1 0"/><geometry><cylinder radius="0.02" length="0.1"/></geometry></collision></link><link name="jaw_a"/><link name="jaw_b"><collision><geometry><sphere radius="0.01"/></geometry></collision></link>
<joint name="stage" type="prismatic"><parent link="base"/><child link="head"/><origin xyz="0.3 0 0.25" rpy="0 0 0"/><axis xyz="0 0 1"/><limit lower="-0.1" upper="0.1" effort="100" velocity="0.2"/></joint>
<joint name="grip" type="prismatic"><parent link="head"/><child link="jaw_a"/><axis xyz="0 1 0"/><limit lower="0" upper="0.07" effort="50" velocity="0.2"/></joint>
<joint name="follower" type="prismatic"><parent link="head"/><child link="jaw_b"/><axis xyz="0 -1 0"/><limit lower="0" upper="0.07" effort="50" velocity="0.2"/><mimic joint="grip" multiplier="1" offset="0"/></joint>
</robot>"#;

const PRESS: &str = r#"[hands.right]
palm = "head"
down = [0, 0, -1]
fingers = [
 { tip = "jaw_a", side = 1, dome_m = [0, 0.02, -0.12], facing = [0, -1, 0], dome_radius_m = 0.015 },
 { tip = "jaw_b", side = 2, dome_m = [0, -0.02, -0.12], facing = [0, 1, 0], dome_radius_m = 0.015 },
]
[joints]
stage = { stiffness = 40000, inertia = 2.0 }
grip = { rest_m = 0.04, stiffness = 20000, inertia = 0.4 }
"#;

fn object(bytes: &[u8]) {
    match Object::parse(&String::from_utf8_lossy(bytes), "fuzz.toml") {
        Ok(object) => assert!(object.required_normal_n().is_finite() && object.mass_kg > 0.0),
        Err(error) => assert!(!error.to_string().is_empty()),
    }
}

fn object_seeds() -> Vec<Vec<u8>> {
    texts([
        include_str!("../../../sim-backend/objects/wood.toml"),
        include_str!("../../../sim-backend/objects/cap.toml"),
        include_str!("../../../sim-backend/objects/open-bottle.toml"),
        include_str!("../../../sim-backend/objects/paper-box.toml"),
    ])
}

fn sensor_model(bytes: &[u8]) {
    match SensorModel::parse(&String::from_utf8_lossy(bytes), "fuzz.toml") {
        Ok(model) => assert!(model.to_toml().is_ok_and(|text| !text.is_empty())),
        Err(error) => assert!(!error.to_string().is_empty()),
    }
}

fn sensor_model_seeds() -> Vec<Vec<u8>> {
    texts(SensorModel::names().filter_map(SensorModel::built_in_text))
}

fn preset(bytes: &[u8]) {
    if let Ok(preset) = toml::from_str::<Preset>(&String::from_utf8_lossy(bytes)) {
        let _model = Model::new(preset);
    }
}

fn preset_seeds() -> Vec<Vec<u8>> {
    let mut seeds: Vec<_> = Preset::ALL
        .iter()
        .filter_map(|preset| toml::to_string(preset).ok())
        .collect();
    seeds.push(
        "base = \"lb2\"\nname = \"mine\"\nfriction_per_stall_force = 0.95\nwalls = []\n".to_owned(),
    );
    texts(seeds)
}

/// Table file of a team: with its hash, and edited by hand.
fn behaviour_table(bytes: &[u8]) {
    let text = String::from_utf8_lossy(bytes);
    let _intact = TableFile::parse(&text, Hash::Required);
    if let Ok(file) = TableFile::parse(&text, Hash::Ignored) {
        let again = TableFile::parse(&file.to_text(), Hash::Required);
        assert!(
            again.is_ok(),
            "the text of a table file is a table file: {again:?}"
        );
    }
}

fn behaviour_seeds() -> Vec<Vec<u8>> {
    texts([include_str!(
        "../../../clients/swarm/tables/r3-two-agents.toml"
    )])
}

fn course_table(bytes: &[u8]) {
    let text = String::from_utf8_lossy(bytes);
    let _rows = CourseFile::parse(&text, Path::new("fuzz.toml"));
    let _kind = CourseFile::is_course_file(&text);
}

fn course_seeds() -> Vec<Vec<u8>> {
    texts([include_str!("../../../clients/swarm/tables/course.toml")])
}

fn grasp_table(bytes: &[u8]) {
    if let Ok((file, _)) = GraspFile::parse(&String::from_utf8_lossy(bytes)) {
        // A table of the evolution is a task of the daemon.
        let task = file.to_task("evolved");
        let parsed = Config::parse(Path::new("task.toml"), &task);
        assert!(parsed.is_ok(), "{parsed:?}");
    }
}

fn grasp_seeds() -> Vec<Vec<u8>> {
    let table = course::table(&Genome::zero(4 << course::BITS.len()));
    let file = GraspFile::new(&table, (3, 40), true, GoalPoints::default());
    texts([toml::to_string(&file).expect("TOML")])
}

fn servo_map(bytes: &[u8]) {
    let Ok(file) = toml::from_str::<MapFile>(&String::from_utf8_lossy(bytes)) else {
        return;
    };
    for check in [Check::Whole, Check::Uncalibrated] {
        if let Ok(map) = validate(&file, check) {
            for servo in map.ports.iter().flat_map(|port| &port.servos) {
                assert!(servo.joint_rad(servo.shaft_rad(0.5)).is_finite());
            }
        }
    }
}

fn servo_map_seeds() -> Vec<Vec<u8>> {
    texts([
        include_str!("../../../clients/robots/two_hand_arm.toml"),
        "robot = \"test-bench\"\n[[port]]\ndevice = \"/dev/null\"\ndriver = \"feetech\"\nbaud = 1000000\nrate_hz = 100.0\n[[port.servo]]\njoint = \"grip\"\nid = 1\nmodel = \"sts3215\"\nzero_rad = 3.0\ngear = 1.0\ntorque_limit_percent = 50.0\n",
    ])
}

fn hand_file(bytes: &[u8]) {
    if let Ok(plan) = Plan::from_toml(&String::from_utf8_lossy(bytes)) {
        let _slots = plan.slots();
    }
}

fn hand_file_seeds() -> Vec<Vec<u8>> {
    texts([
        "hand = \"left\"\n[[port]]\nsensor = \"optoforce\"\ndevice = \"/dev/ttyUSB0\"\nnewtons-per-count = \"300/7925,300/8641,2000/6049\"\n[[port]]\nsensor = \"netft\"\ndevice = \"192.168.1.1\"\nfinger = 1\nnewtons-per-count = \"1,1,1\"\n",
        "hand = \"right\"\nlayout = \"pad-31\"\n[[port]]\nsensor = \"paxini\"\ndevice = \"/dev/ttyACM0\"\nzero = true\naxes = \"z,x,y\"\nnewtons-per-count = \"0.1,0.1,0.1\"\nrate-hz = 83\n",
    ])
}

fn calibration(bytes: &[u8]) {
    if let Ok(calibration) = Calibration::parse(&String::from_utf8_lossy(bytes)) {
        let values = vec![1.0; 3 * calibration.elements_in()];
        for element in 0..calibration.elements_out() {
            let _force_n = calibration.force_n(element, &values);
        }
    }
}

fn calibration_seeds() -> Vec<Vec<u8>> {
    texts([
        "format = 1\nsource = \"a test\"\nmodel = \"matrix\"\nzero = [1.0, 2.0, 3.0]\nnewtons = [[[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]]\n[quality]\npresses = 3\nerror_n = [0.1, 0.1, 0.1]\nerror_share = [0.1, 0.1, 0.1]\nnoise_n = [0.1, 0.1, 0.1]\ndrift_n_min = 0.0\n",
        "format = 1\nsource = \"a test\"\nmodel = \"resultant\"\nzero = [1.0, 2.0, 3.0, 4.0, 5.0, 6.0]\nnewtons = [[[1.0, 0.0, 0.0, 1.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 1.0, 0.0, 0.0, 1.0]]]\n[quality]\npresses = 3\nerror_n = [0.1, 0.1, 0.1]\nerror_share = [0.1, 0.1, 0.1]\nnoise_n = [0.1, 0.1, 0.1]\ndrift_n_min = 0.0\n",
    ])
}

fn teleop_file(bytes: &[u8]) {
    let _targets = count_targets(&String::from_utf8_lossy(bytes));
}

fn teleop_seeds() -> Vec<Vec<u8>> {
    texts([
        "# to the right\nt_s,hand,x_m,y_m,z_m,yaw_rad,opening_m\n0,right,0.3,-0.2,0.1,1.57,0.06\n\n1.5,left,0.3,0.2,0.1,0,hold\n",
        "{\"t_s\":0,\"hand\":\"right\",\"x_m\":0.3,\"y_m\":-0.2,\"z_m\":0.1,\"yaw_rad\":1.57,\"opening_m\":0.06}\n{\"t_s\":1.5,\"hand\":\"left\",\"x_m\":0.3,\"y_m\":0.2,\"z_m\":0.1,\"yaw_rad\":0,\"opening_m\":\"hold\"}\n",
    ])
}
