//! The README's tables are those that were measured, and some of the trials behind them come out the same today.
//!
//! `atas eval all --golden clients/evaluation/golden` and `atas eval errors --golden clients/evaluation/golden` measure
//! anew and write what this test reads: a table, and of every series behind it the first trial and the one in the middle. A
//! controller or a simulator that behaves otherwise fails here, until its figures are measured and the README has them.

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::atomic::AtomicBool;

use atas_evaluation::{Condition, GripPolicy, Plan, Task, TrialRow, seeds};
use sim_backend::Object;

/// A row by its columns.
type Columns = BTreeMap<String, String>;
/// The columns that say which trial a row is of.
const KEY: [&str; 7] = [
    "task", "policy", "errors", "rate_hz", "noise", "object", "seed",
];

fn golden(file: &str) -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("golden")
        .join(file);
    std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

fn columns(csv: &[u8]) -> Vec<Columns> {
    let mut reader = csv::Reader::from_reader(csv);
    let names = reader.headers().expect("names").clone();
    let named = |row: csv::StringRecord| {
        let cells = names.iter().zip(&row);
        cells
            .map(|(name, cell)| (name.to_owned(), cell.to_owned()))
            .collect()
    };
    let rows = reader.records().map(|row| named(row.expect("a row")));
    rows.collect()
}

fn written(rows: &[TrialRow]) -> Vec<Columns> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    for row in rows {
        writer.serialize(row).expect("it has a form");
    }
    columns(&writer.into_inner().expect("memory"))
}

#[test]
fn the_tables_of_the_readme_are_those_that_were_measured() {
    let readme = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../README.md");
    let readme = std::fs::read_to_string(readme).expect("readable");
    for file in ["all.md", "errors.md"] {
        let table = golden(file);
        let missing = table
            .lines()
            .find(|line| !readme.lines().any(|other| other == *line));
        assert_eq!(
            missing, None,
            "a line of golden/{file} is not in the README"
        );
        assert!(
            readme.contains(&table),
            "golden/{file} stands otherwise in the README"
        );
    }
}

/// Runs the first kept trial of a task again, with all policies under one condition.
fn check(file: &str, task: Task, condition: Condition, baselines: bool) {
    let kept = columns(golden(file).as_bytes());
    let of_task = kept.iter().find(|row| row["task"] == task.name());
    let first = of_task.unwrap_or_else(|| panic!("golden/{file} has {}", task.name()));
    let seed: u64 = first["seed"].parse().expect("a seed");
    assert_eq!(seeds::purpose(seed, 1), "judging");
    let baselines = match baselines {
        true => GripPolicy::baselines(task, None).to_vec(),
        false => Vec::new(),
    };
    let plan = Plan {
        task,
        objects: vec![Object::built_in(&first["object"]).expect("built in")],
        trials: 1,
        first_seed: seed,
        conditions: vec![condition],
        baselines,
        compare_everywhere: false,
        threads: 0,
        settings: atas_core::Settings::default(),
    };
    let evaluated = plan.run(&AtomicBool::new(false), || ());
    let rows = evaluated.expect("it runs").expect("nobody stopped it").rows;
    for today in written(&rows.concat()) {
        let same = |row: &&Columns| KEY.iter().all(|name| row[*name] == today[*name]);
        let then = kept.iter().find(same);
        assert_eq!(
            Some(&today),
            then,
            "golden/{file} was measured with something else"
        );
    }
}

#[test]
fn trials_behind_the_tables_come_out_as_they_were_measured() {
    for task in Task::ALL {
        let usual = task.conditions().swap_remove(0);
        check("all.csv", task, usual, task != Task::Assembly);
    }
    let all_errors = Task::Grasp.error_conditions().pop().expect("all at once");
    check("errors.csv", Task::Grasp, all_errors, false);
}
