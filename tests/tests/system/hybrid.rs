//! Tests of both methodologies in one robot: separate processes give the same bits as one process.

use std::process::Command;

use atas_core::Settings;
use atas_evaluation::hybrid::{HybridPlan, Reflexes};
use ebts::course::table_file::{BUILT_IN, CourseFile};
use robot_model::RobotModel;
use sim_backend::Object;
use system_tests::{binary, lock_shared};

const OBJECT: &str = "wood";

/// Runs a course over the bus; returns its JSON result and the exit code.
fn over_the_bus(robots: usize, seed: u64, reflexes: Reflexes) -> (String, Option<i32>) {
    let (robots, seed) = (robots.to_string(), seed.to_string());
    let mut demo = Command::new(binary("atas"));
    demo.args(["demo", "hybrid", "--format", "json", "--object", OBJECT]);
    demo.args(["--robots", &robots, "--seed", &seed]);
    if reflexes == Reflexes::Frozen {
        demo.arg("--frozen");
    }
    let output = demo.output().expect("it runs");
    let message = String::from_utf8(output.stdout).expect("UTF-8");
    (message.trim().to_owned(), output.status.code())
}

/// Runs the course in process.
fn in_process(robots: usize, seed: u64, reflexes: Reflexes) -> (String, Option<i32>) {
    let (_, table) = CourseFile::from_name(BUILT_IN).expect("it ships");
    let plan = HybridPlan {
        robots,
        trials: 1,
        first_seed: seed,
        table,
        reflexes,
        objects: vec![Object::built_in(OBJECT).expect("built in")],
        threads: 1,
        settings: Settings::default(),
    };
    let model = RobotModel::two_hand_arm().expect("built in");
    let trial = plan.trial(&model, 0, |_, _, _| ()).expect("a course");
    let code = match trial.failure() {
        None => 0,
        Some(_) => 6,
    };
    (serde_json::to_string(&trial).expect("JSON"), Some(code))
}

/// Forces, slip and positions are compared to the last digit, so any differing command is visible.
#[test]
fn bus_course_equals_in_process_course() {
    let _shared = lock_shared();
    for (robots, seed, reflexes) in [(1, 4, Reflexes::Frozen), (2, 5, Reflexes::On)] {
        assert_eq!(
            over_the_bus(robots, seed, reflexes),
            in_process(robots, seed, reflexes),
            "{robots} robots, seed {seed}, {reflexes:?}"
        );
    }
}
