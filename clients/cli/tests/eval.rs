//! Evaluation: the same numbers whatever the number of threads, and the fields that scripts rely on.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use atas_cli::eval::{Plan, Report, trial_seed};
use serde_json::Value;
use sim_backend::Object;

/// One object that can be held and one that cannot.
fn plan(threads: usize) -> Plan {
    let object = |name| Object::built_in(name).expect("built in");
    Plan {
        objects: vec![object("paper-box"), object("heavy-block")],
        seeds: 2,
        noise: 1.0,
        rate_hz: 1000,
        threads,
        settings: atas::Settings::default(),
    }
}

fn run(plan: &Plan) -> Report {
    let report = plan.run(&AtomicBool::new(false), || ());
    report.expect("it runs").expect("nobody stopped it")
}

/// The report without the two fields that are times.
fn timeless(report: Report) -> Report {
    Report {
        realtime_factor: 0.0,
        wall_s: 0.0,
        ..report
    }
}

#[test]
fn the_numbers_do_not_depend_on_the_threads() {
    let [one, many] = [1, 3].map(|threads| timeless(run(&plan(threads))));
    assert_eq!(one, many);
    assert_eq!(one.trials, 4);
    assert_eq!(one.feasible.trials, 2, "a paper box is light");
    assert_eq!(one.infeasible.trials, 2, "1.5 kg is too much for 8 N");
}

#[test]
fn a_trial_does_not_depend_on_the_others() {
    let both = run(&plan(0));
    let mut alone = plan(0);
    alone.objects.remove(0);
    assert_eq!(run(&alone).families[0], both.families[1]);
}

#[test]
fn every_trial_has_its_own_seed() {
    let seeds = [("a", 1), ("a", 2), ("b", 1), ("b", 2)].map(|(name, n)| trial_seed(name, n));
    for (i, seed) in seeds.iter().enumerate() {
        assert!(!seeds[..i].contains(seed));
    }
}

#[test]
fn json_fields_are_a_contract() {
    let mut small = plan(0);
    small.objects.truncate(1);
    small.seeds = 1;
    let text = serde_json::to_string(&run(&small)).expect("it is JSON");
    let value: Value = serde_json::from_str(&text).expect("it reads back");
    let keys = |value: &Value| match value {
        Value::Object(map) => map.keys().cloned().collect::<Vec<String>>().join(" "),
        other => panic!("{other}"),
    };
    let sorted = |names: &str| {
        let mut names: Vec<&str> = names.split(' ').collect();
        names.sort_unstable();
        names.join(" ")
    };
    let feasible = sorted("trials held crushed dropped over_grip_median");
    let infeasible = sorted("trials refused crushed");
    assert_eq!(
        keys(&value),
        sorted(
            "task trials feasible infeasible realtime_factor wall_s success ci95 failures borderline seeds noise \
             rate_hz families"
        )
    );
    assert_eq!(keys(&value["feasible"]), feasible);
    assert_eq!(keys(&value["infeasible"]), infeasible);
    let first = [
        "task",
        "trials",
        "feasible",
        "infeasible",
        "realtime_factor",
        "wall_s",
    ];
    let places = first.map(|key| text.find(&format!("\"{key}\":")));
    assert!(places[2..].is_sorted() && places[0] == Some(1), "{text}");
    assert_eq!(value["task"], "grasp");
    assert!(value["infeasible"]["trials"] == 0 && value["feasible"]["trials"] == 1);
}

#[test]
fn it_can_be_stopped_and_counts_what_is_done() {
    let done = AtomicU64::new(0);
    let stop = AtomicBool::new(true);
    let report = plan(1).run(&stop, || {
        done.fetch_add(1, Ordering::Relaxed);
    });
    assert!(report.expect("it runs").is_none());
    assert_eq!(done.into_inner(), 0);
}

#[test]
fn nothing_to_evaluate_is_an_error() {
    let mut none = plan(1);
    none.objects.clear();
    let error = none
        .run(&AtomicBool::new(false), || ())
        .expect_err("nothing");
    assert!(error.to_string().contains("--objects"), "{error}");
}
