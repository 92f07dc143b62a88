//! Nominal trials show which tasks a robot can do.

use atas_evaluation::{NominalTrial, Task};
use robot_model::{RobotFiles, RobotModel};

/// Arm of six joints whose gripper has one drive; its other joints mimic the drive.
const URDF: &str = r#"<robot name="six-axis">
  <link name="base"/> <link name="link1"/> <link name="link2"/> <link name="link3"/>
  <link name="link4"/> <link name="link5"/> <link name="link6"/>
  <link name="left_knuckle"/> <link name="left_finger"/>
  <link name="right_knuckle"/> <link name="right_finger"/>
  <joint name="joint1" type="revolute"><parent link="base"/><child link="link1"/><origin xyz="0 0 0.27"/>
    <axis xyz="0 0 1"/><limit lower="-6.2" upper="6.2" effort="50" velocity="3"/></joint>
  <joint name="joint2" type="revolute"><parent link="link1"/><child link="link2"/>
    <axis xyz="0 1 0"/><limit lower="-2" upper="2" effort="50" velocity="3"/></joint>
  <joint name="joint3" type="revolute"><parent link="link2"/><child link="link3"/><origin xyz="0.05 0 0.28"/>
    <axis xyz="0 1 0"/><limit lower="-3.8" upper="0.2" effort="50" velocity="3"/></joint>
  <joint name="joint4" type="revolute"><parent link="link3"/><child link="link4"/><origin xyz="0.08 0 -0.34"/>
    <axis xyz="0 0 -1"/><limit lower="-6.2" upper="6.2" effort="50" velocity="3"/></joint>
  <joint name="joint5" type="revolute"><parent link="link4"/><child link="link5"/>
    <axis xyz="0 1 0"/><limit lower="-1.7" upper="3.1" effort="30" velocity="3"/></joint>
  <joint name="joint6" type="revolute"><parent link="link5"/><child link="link6"/><origin xyz="0.08 0 -0.1"/>
    <axis xyz="0 0 -1"/><limit lower="-6.2" upper="6.2" effort="20" velocity="3"/></joint>
  <joint name="drive" type="revolute"><parent link="link6"/><child link="left_knuckle"/><origin xyz="0 0.035 -0.06"/>
    <axis xyz="-1 0 0"/><limit lower="0" upper="0.85" effort="50" velocity="2"/></joint>
  <joint name="left_finger_joint" type="revolute"><parent link="left_knuckle"/><child link="left_finger"/>
    <origin xyz="0 0.035 -0.042"/><axis xyz="1 0 0"/><limit lower="0" upper="0.85" effort="50" velocity="2"/>
    <mimic joint="drive"/></joint>
  <joint name="right_knuckle_joint" type="revolute"><parent link="link6"/><child link="right_knuckle"/>
    <origin xyz="0 -0.035 -0.06"/><axis xyz="1 0 0"/><limit lower="0" upper="0.85" effort="50" velocity="2"/>
    <mimic joint="drive"/></joint>
  <joint name="right_finger_joint" type="revolute"><parent link="right_knuckle"/><child link="right_finger"/>
    <origin xyz="0 -0.035 -0.042"/><axis xyz="-1 0 0"/><limit lower="0" upper="0.85" effort="50" velocity="2"/>
    <mimic joint="drive"/></joint>
</robot>"#;

/// Loads the arm with these rest angles of its pitch joints, degrees.
fn six_axis([second, third, fifth]: [i32; 3]) -> RobotModel {
    let robot_file = format!(
        r#"
        [hands.right]
        palm = "link6"
        down = [0, 0, -1]
        fingers = [
            {{ tip = "left_finger", side = 1, dome_m = [0, -0.012, -0.06], facing = [0, -1, 0], dome_radius_m = 0.015 }},
            {{ tip = "right_finger", side = 2, dome_m = [0, 0.012, -0.06], facing = [0, 1, 0], dome_radius_m = 0.015 }},
        ]
        [joints]
        joint1 = {{ stiffness = 8000, inertia = 0.5 }}
        joint2 = {{ rest_deg = {second}, stiffness = 8000, inertia = 0.5 }}
        joint3 = {{ rest_deg = {third}, stiffness = 6000, inertia = 0.4 }}
        joint4 = {{ stiffness = 6000, inertia = 0.2 }}
        joint5 = {{ rest_deg = {fifth}, stiffness = 2000, inertia = 0.08 }}
        joint6 = {{ stiffness = 800, inertia = 0.03 }}
        drive = {{ rest_deg = 17, stiffness = 200, inertia = 0.005 }}
        "#
    );
    RobotModel::load(URDF, &robot_file).expect("valid robot")
}

/// Regression: screwing was promised to an arm whose hand rests beside the cap and hits it.
#[test]
fn task_that_kinematics_allow_may_fail_its_trial() {
    let check = |rest_deg: [i32; 3], done: [bool; 3]| {
        let robot = six_axis(rest_deg);
        let trials = NominalTrial::run_all(&robot).expect("simulated");
        let tasks = [Task::Grasp, Task::PickPlace, Task::Screw];
        assert_eq!(trials.iter().map(|t| t.task).collect::<Vec<_>>(), tasks);
        let found: Vec<bool> = trials.iter().map(|trial| trial.done).collect();
        assert_eq!(found, done, "{trials:?}");
        assert_eq!(trials[2].rests_below_object(), !done[2], "{trials:?}");
    };
    check([-20, -30, 50], [true, true, false]);
    check([-40, -40, 80], [true, true, true]);
}

#[test]
fn built_in_robots_do_all_their_tasks() {
    for name in robot_model::shipped_names() {
        let robot = RobotFiles::find(&name).and_then(|files| files.load());
        let robot = robot.expect("built-in robot");
        for trial in NominalTrial::run_all(&robot).expect("simulated") {
            assert!(trial.done && trial.reason.is_none(), "{name}: {trial:?}");
        }
    }
}

#[test]
fn object_fits_a_small_gripper() {
    let files = RobotFiles::find("test-bench").expect("built in");
    let narrow = files.robot_file.replace("rest_m = 0.035", "rest_m = 0.02");
    let narrow = narrow.replace("opening_m = [0.02, 0.11]", "opening_m = [0.01, 0.045]");
    let urdf = files.urdf.replace("upper=\"0.07\"", "upper=\"0.0225\"");
    let robot = RobotModel::load(&urdf, &narrow).expect("valid robot");
    let trials = NominalTrial::run_all(&robot).expect("simulated");
    let [grasp] = &trials[..] else {
        panic!("{trials:?}")
    };
    assert!(grasp.width_m < 0.045 && grasp.done, "{grasp:?}");
}
