//! Tests of the fault catalogue and of the injection.

use std::path::Path;
use std::sync::atomic::AtomicBool;

use atas_core::Settings;
use atas_evaluation::{Task, seeds};
use atas_faults::process::Environment;
use atas_faults::{CATALOGUE, Evidence, Fault, FaultPlan, FaultReport, Injection, Reaction, find};
use sim_backend::Object;

fn plan(faults: Vec<&'static Fault>, threads: usize) -> FaultPlan {
    FaultPlan {
        faults,
        tasks: vec![Task::Grasp],
        phase: Some("lift".to_owned()),
        object: Object::built_in("wood").expect("built in"),
        object_name: "wood".to_owned(),
        seeds: 2,
        first_seed: seeds::EVALUATION_START,
        robot: robot_model::TWO_HAND_ARM,
        settings: Settings::default(),
        environment: Environment {
            robot: "two-hand-arm".to_owned(),
            config: None,
        },
        threads,
    }
}

fn run(plan: &FaultPlan) -> FaultReport {
    let report = plan.run(&AtomicBool::new(false), || ());
    report.expect("it runs").expect("not stopped")
}

#[test]
fn numbers_are_complete_and_in_order() {
    let ids: Vec<&str> = CATALOGUE.iter().map(|fault| fault.id).collect();
    assert!(ids.is_sorted(), "{ids:?}");
    for number in 1..=63 {
        let number = format!("F{number:02}");
        assert!(find(&number).next().is_some(), "{number} is missing");
    }
    let mut names: Vec<&str> = CATALOGUE.iter().map(|fault| fault.name).collect();
    names.sort_unstable();
    names.dedup();
    assert_eq!(names.len(), CATALOGUE.len(), "a name appears twice");
}

#[test]
fn every_named_test_exists() {
    let top = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    for fault in CATALOGUE {
        let Evidence::Test(test) = fault.evidence else {
            continue;
        };
        let (file, name) = test.split_once("::").expect("file::name");
        let text = std::fs::read_to_string(top.join(file)).expect(file);
        assert!(
            text.contains(&format!("fn {name}(")),
            "{}: {test}",
            fault.id
        );
    }
}

#[test]
fn faults_are_found_by_number_and_name() {
    let check = |text: &str, expected: &[&str]| {
        let ids: Vec<&str> = find(text).map(|fault| fault.id).collect();
        assert_eq!(ids, expected, "{text}");
    };
    check("F01", &["F01"]);
    check("F12", &["F12a", "F12b"]);
    check("F12b", &["F12b"]);
    check("frames-lost", &["F01"]);
    check("F", &[]);
    check("F99", &[]);
    check("", &[]);
}

#[test]
fn grip_survives_lost_frames_and_a_restart() {
    let faults: Vec<_> = ["F01", "F05", "F25a"].into_iter().flat_map(find).collect();
    let report = run(&plan(faults, 0));
    assert!(report.has_passed(), "{report:#?}");
    assert_eq!(report.unsafe_outputs, 0);
    let runs: Vec<usize> = report.faults.iter().map(|row| row.runs).collect();
    assert_eq!(runs, [2, 2, 2], "one phase with two seeds");
    assert!(report.faults[0].worst_ticks.is_some_and(|ticks| ticks <= 6));
}

/// Regression: the masked element kept its force when the fingertips let go, which caused HOLD.
#[test]
fn masked_element_does_not_hold_the_hand_that_lets_go() {
    let mut plan = plan(["F12a", "F14"].into_iter().flat_map(find).collect(), 0);
    plan.tasks = vec![Task::PickPlace];
    plan.phase = Some("let go".to_owned());
    let report = run(&plan);
    assert!(report.has_passed(), "{report:#?}");
}

/// Regression: the element had carried two fifths of the force, so that the joints and the other
/// elements disagreed.
#[test]
fn masked_element_of_a_narrow_contact_does_not_hold_the_hand() {
    let mut plan = plan(["F12a", "F14"].into_iter().flat_map(find).collect(), 0);
    plan.tasks = vec![Task::Assembly];
    plan.phase = Some("probe".to_owned());
    (plan.first_seed, plan.seeds) = (20_020, 1);
    let report = run(&plan);
    assert!(report.has_passed(), "{report:#?}");
}

/// Regression: on the way home after screwing, the wrist turned faster than its joint can. The arm
/// swung to compensate, and the gate caused HOLD.
#[test]
fn wrist_that_has_turned_a_cap_goes_home_without_hold() {
    let mut plan = plan(find("F05").collect(), 0);
    plan.tasks = vec![Task::Screw];
    plan.phase = Some("home".to_owned());
    plan.robot = robot_model::RobotFiles::find("arm7-gripper").expect("built in");
    (plan.first_seed, plan.seeds) = (20_003, 1);
    let report = run(&plan);
    assert!(report.has_passed(), "{report:#?}");
}

/// Regression: the next controller moved the fingertips of a tilted hand, and the object slid.
#[test]
fn restart_keeps_the_grip_of_a_hand_with_two_fingertips_on_one_side() {
    let mut plan = plan(find("F25a").collect(), 0);
    plan.robot = robot_model::RobotFiles::find("three-finger").expect("built in");
    plan.phase = Some("hold".to_owned());
    plan.first_seed = 20_003;
    let report = run(&plan);
    assert!(report.has_passed(), "{report:#?}");
}

#[test]
fn late_reaction_fails_with_the_command_that_repeats_it() {
    static TOO_STRICT: Fault = Fault {
        id: "F01",
        name: "frames-lost",
        about: "the sensor stops",
        evidence: Evidence::Injected(Injection::Frames("drop=1", None), Reaction::Hold(1)),
    };
    let report = run(&plan(vec![&TOO_STRICT], 0));
    let row = &report.faults[0];
    assert_eq!((row.passed, report.unsafe_outputs), (0, 0), "{row:?}");
    let command = "atas fault run F01 --robot two-hand-arm --task grasp --at lift --seed 20001";
    assert!(row.failures[0].starts_with(command), "{row:?}");
    assert_eq!(
        report,
        run(&plan(vec![&TOO_STRICT], 1)),
        "independent of threads"
    );
}

#[test]
fn repeating_command_quotes_phase_and_names_the_object() {
    static TOO_STRICT: Fault = Fault {
        id: "F05",
        name: "short-gap",
        about: "three frames are missing",
        evidence: Evidence::Injected(Injection::Frames("drop=1", Some(0.003)), Reaction::Hold(0)),
    };
    let mut plan = plan(vec![&TOO_STRICT], 0);
    plan.tasks = vec![Task::PickPlace];
    plan.phase = Some("let go".to_owned());
    let report = run(&plan);
    let words = "--at 'let go' --seed 20001 --object wood: ";
    assert!(report.faults[0].failures[0].contains(words), "{report:#?}");
}

#[test]
fn bounds_follow_the_configuration() {
    let mut plan = plan(["F01", "F02"].into_iter().flat_map(find).collect(), 0);
    plan.seeds = 1;
    plan.settings.intake.hold_age_s = 0.02;
    plan.settings.intake.frozen_frames = 100.0;
    let report = run(&plan);
    let bounds: Vec<_> = report.faults.iter().map(|row| row.bound_ticks).collect();
    assert_eq!(bounds, [Some(21), Some(110)]);
    assert!(report.has_passed(), "{report:#?}");
    // Later than with the default limits, so the settings have reached the controller.
    assert!(report.faults[0].worst_ticks > Some(6), "{report:#?}");
}

#[test]
fn unknown_phase_is_an_error() {
    let mut plan = plan(find("F01").collect(), 0);
    plan.phase = Some("fly".to_owned());
    let error = plan.run(&AtomicBool::new(false), || ()).unwrap_err();
    let text = error.to_string();
    assert!(
        text.contains("\"fly\"") && text.contains("lift, probe, reach"),
        "{text}"
    );
}
