//! Tests of the evaluation: results independent of threads, and the JSON fields that scripts use.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use atas_evaluation::{GripPolicy, Plan, Report, Task, conditions, trial_seed};
use serde_json::Value;
use sim_backend::Object;

/// Plan with two trials per object, under the task's first condition.
fn plan(task: Task, objects: &[&str], threads: usize) -> Plan {
    let object = |name: &&str| Object::built_in(name).expect("built in");
    Plan {
        robot: robot_model::TWO_HAND_ARM,
        skin: None,
        task,
        objects: objects.iter().map(object).collect(),
        trials: 2 * objects.len() as u64,
        first_seed: 1,
        conditions: vec![conditions(task).swap_remove(0)],
        baselines: Vec::new(),
        compare_everywhere: false,
        engine: None,
        threads,
        settings: atas_core::Settings::default(),
    }
}

fn grasps(threads: usize) -> Plan {
    plan(Task::Grasp, &["paper-box", "heavy-block"], threads)
}

fn run(plan: &Plan) -> Report {
    let report = plan.run(&AtomicBool::new(false), || ());
    report.expect("it runs").expect("not stopped").report
}

fn timeless(report: Report) -> Report {
    Report {
        realtime_factor: 0.0,
        wall_s: 0.0,
        ..report
    }
}

/// An engine that ends in its first tick costs a trial, not the evaluation.
#[test]
fn ended_engine_discards_its_trial() {
    let folder = tempfile::tempdir().expect("temporary folder");
    let path = folder.path().join("engine.sh");
    // Reads the scene, reports that it is ready, and ends.
    let ready = "exec 3<&0; cat <&3 >/dev/null & printf '\\003\\000\\000\\000\\000\\000\\000\\000'; sleep 0.5";
    std::fs::write(&path, ready).expect("writable folder");
    let command = format!("sh {}", path.display());
    let report = run(&Plan {
        engine: Some(command.parse().expect("valid command")),
        ..plan(Task::Grasp, &["wood"], 1)
    });
    assert_eq!(report.tally.success, 0.0);
    let (reason, count) = report.tally.failures.iter().next().expect("a failure");
    assert!(
        reason.starts_with("discarded: could not exchange data"),
        "{reason}"
    );
    assert_eq!((*count, report.tally.failures.len()), (2, 1));
}

#[test]
fn results_do_not_depend_on_thread_count() {
    let with = |threads| Plan {
        baselines: GripPolicy::baselines(Task::Grasp, None).to_vec(),
        ..grasps(threads)
    };
    let [one, many] = [1, 3].map(|threads| timeless(run(&with(threads))));
    assert_eq!(one, many);
    assert_eq!((one.tally.trials, one.baselines.len()), (4, 2));
    for row in &one.baseline_rows {
        let lifts = row
            .row
            .physics
            .as_ref()
            .map(|p| p.feasible.held + p.feasible.crushed);
        assert!(lifts > Some(0), "baseline without a lift: {row:?}");
    }
    let physics = one.physics.expect("a grasp has loads");
    assert_eq!(physics.feasible.trials, 2, "a paper box is light");
    assert_eq!(physics.infeasible.trials, 2, "1.5 kg is too much for 8 N");
}

#[test]
fn trials_are_independent() {
    let both = run(&grasps(0));
    let alone = run(&plan(Task::Grasp, &["heavy-block"], 0));
    assert_eq!(alone.families[0], both.families[1]);
    let second = Plan {
        first_seed: 2,
        trials: 1,
        ..plan(Task::Grasp, &["heavy-block"], 0)
    };
    let slips = |report: &Report| report.tally.failures.values().sum::<u64>();
    assert!(slips(&run(&second)) <= slips(&alone));
}

#[test]
fn every_task_runs_from_end_to_end() {
    let check = |task: Task, object: &str, measure: &str| {
        let report = run(&plan(task, &[object], 0));
        assert_eq!(report.tally.failures.len(), 0, "{report:?}");
        assert_eq!((report.tally.success, report.tally.trials), (1.0, 2));
        assert!(report.tally.medians[measure].is_finite(), "{report:?}");
        assert_eq!(report.task, task.name());
    };
    check(Task::PickPlace, "slippery-200", "latency_ms");
    check(Task::Screw, "cap", "tightness");
    check(Task::Assembly, "cap", "tightness");
}

#[test]
fn every_trial_has_its_own_seed() {
    let seeds = [("a", 1), ("a", 2), ("b", 1), ("b", 2)].map(|(name, n)| trial_seed(name, n));
    for (i, seed) in seeds.iter().enumerate() {
        assert!(!seeds[..i].contains(seed));
    }
}

#[test]
fn json_fields_are_stable() {
    let mut small = plan(Task::Grasp, &["paper-box"], 0);
    small.trials = 1;
    small.baselines = GripPolicy::baselines(Task::Grasp, None).to_vec();
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
    let feasible = sorted("trials held refused crushed dropped success ci95 over_grip_median");
    let infeasible = sorted("trials refused held crushed dropped success ci95");
    let tally = "trials success ci95 failures hidden_slides hidden_turns medians largest";
    let physics = "feasible infeasible by_physics borderline f2_ratio_median f2_ratio_deviation";
    let shape = |own: &str| sorted(&format!("{own} {tally} {physics}"));
    let own = "task robot baselines realtime_factor wall_s seeds first_seed seeds_for noise rate_hz errors families rows \
         baseline_rows";
    assert_eq!(keys(&value), shape(own));
    assert_eq!(keys(&value["feasible"]), feasible);
    assert_eq!(keys(&value["infeasible"]), infeasible);
    assert_eq!(keys(&value["families"][0]), shape("object"));
    assert_eq!(keys(&value["rows"][0]), shape("noise rate_hz errors"));
    assert_eq!(
        keys(&value["baseline_rows"][0]),
        shape("baseline setting noise rate_hz errors")
    );
    assert_eq!(
        keys(&value["by_physics"]),
        sorted("success ci95 feasible infeasible")
    );
    assert_eq!(keys(&value["by_physics"]["feasible"]), feasible);
    assert_eq!(value["seeds_for"], "tuning");
    assert_eq!(keys(&value["baselines"]), "fixed_force slip_reactive");
    assert!(
        text.starts_with(
            "{\"task\":\"grasp\",\"robot\":\"two-hand-arm\",\"trials\":1,\"success\":"
        ),
        "{text}"
    );
    assert_eq!(value["task"], "grasp");
    assert!(value["infeasible"]["trials"] == 0 && value["feasible"]["trials"] == 1);
}

#[test]
fn evaluation_stops_on_request() {
    let done = AtomicU64::new(0);
    let stop = AtomicBool::new(true);
    let report = grasps(1).run(&stop, || {
        done.fetch_add(1, Ordering::Relaxed);
    });
    assert!(report.expect("it runs").is_none());
    assert_eq!(done.into_inner(), 0);
}

#[test]
fn empty_plan_is_an_error() {
    let mut none = grasps(1);
    none.objects.clear();
    let error = none
        .run(&AtomicBool::new(false), || ())
        .expect_err("nothing");
    assert!(error.to_string().contains("--objects"), "{error}");
}
