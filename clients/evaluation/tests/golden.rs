//! The README's tables are those that were measured, and some of the trials behind them come out the same today.
//!
//! `atas eval all --golden clients/evaluation/golden` measures anew and writes what this test reads, and `atas eval errors` with
//! it: a table, and of every series behind it the first trial and the one in the middle. A controller or a simulator that
//! behaves otherwise fails here, until its figures are measured and the README has them.

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
    for name in ["all.md", "errors.md"] {
        let table = golden(name);
        let missing = table
            .lines()
            .find(|line| !readme.lines().any(|other| other == *line));
        assert_eq!(
            missing, None,
            "a line of golden/{name} is not in the README"
        );
        assert!(
            readme.contains(&table),
            "golden/{name} stands otherwise in the README"
        );
    }
}

/// Runs the first kept trial of a task under a condition again, with all policies.
fn check(task: Task, condition: Condition, kept: &[Columns], baselines: bool) {
    let asked =
        |row: &&Columns| row["task"] == task.name() && row["errors"] == condition.errors.name;
    let first = kept.iter().find(asked);
    let first = first.unwrap_or_else(|| panic!("golden has {}", task.name()));
    let seed: u64 = first["seed"].parse().expect("a seed");
    assert_eq!(seeds::purpose(seed, 1), "judging");
    let baselines = match baselines {
        true => GripPolicy::baselines(task, None).to_vec(),
        false => Vec::new(),
    };
    let plan = Plan {
        robot: robot_model::TWO_HAND_ARM,
        skin: None,
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
            "the golden file was measured with something else"
        );
    }
}

#[test]
fn trials_behind_the_table_come_out_as_they_were_measured() {
    let kept = columns(golden("all.csv").as_bytes());
    for task in Task::ALL {
        // A baseline's assembly takes longest.
        let usual = task.conditions().swap_remove(0);
        check(task, usual, &kept, task != Task::Assembly);
    }
}

#[test]
fn trials_with_errors_come_out_as_they_were_measured() {
    let kept = columns(golden("errors.csv").as_bytes());
    for task in [Task::Grasp, Task::PickPlace, Task::Screw] {
        for condition in task.error_conditions() {
            check(task, condition, &kept, false);
        }
    }
}
