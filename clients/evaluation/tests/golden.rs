//! Golden test: the tables of the results page are the measured ones, and some of their trials
//! reproduce.
//!
//! `atas eval all --golden clients/evaluation/golden` measures and writes the files that this test
//! reads, as do `atas eval errors`, `robots` and `skins`: a table, and the first and the middle
//! trial of each series. After a change of behaviour, measure again and update the page.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::sync::atomic::AtomicBool;

use atas_evaluation::{
    Condition, GripPolicy, Plan, Task, TrialRow, conditions, error_conditions, seeds,
};
use robot_model::{RobotFiles, SHIPPED, TWO_HAND_ARM};
use shm_schemas::layout::NamedLayout;
use sim_backend::Object;

/// CSV row by column name.
type Columns = BTreeMap<String, String>;
/// Columns that identify a trial.
const KEY: [&str; 9] = [
    "robot", "skin", "task", "policy", "errors", "rate_hz", "noise", "object", "seed",
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
fn results_page_matches_golden_files() {
    let page = Path::new(env!("CARGO_MANIFEST_DIR")).join("../guide/src/results.md");
    let page = std::fs::read_to_string(page).expect("readable");
    for name in ["all.md", "errors.md", "robots.md", "skins.md"] {
        let table = golden(name);
        let missing = table
            .lines()
            .find(|line| !page.lines().any(|other| other == *line));
        assert_eq!(
            missing, None,
            "a line of golden/{name} is missing on the results page"
        );
        assert!(
            page.contains(&table),
            "golden/{name} differs from the table on the results page"
        );
    }
}

struct Series {
    robot: RobotFiles,
    skin: Option<NamedLayout>,
    task: Task,
    condition: Condition,
}

impl Series {
    fn usual(task: Task, condition: Condition) -> Self {
        Self {
            robot: TWO_HAND_ARM,
            skin: None,
            task,
            condition,
        }
    }

    /// Creates a grasp series at full sensor rate, as for robots and skins.
    fn grasp(robot: RobotFiles, skin: Option<&str>) -> Self {
        Self {
            skin: skin.map(|name| name.parse().expect("a layout")),
            robot,
            ..Self::usual(Task::Grasp, conditions(Task::Grasp).swap_remove(0))
        }
    }

    fn has(&self, row: &Columns) -> bool {
        let skin = self.skin.map_or(String::new(), |skin| skin.to_string());
        row["robot"] == self.robot.name
            && row["skin"] == skin
            && row["task"] == self.task.name()
            && row["errors"] == self.condition.errors.name
            && row["rate_hz"] == self.condition.rate_hz.to_string()
    }

    /// Repeats the first stored trial, with all policies if `baselines` is true.
    fn check(self, kept: &[Columns], baselines: bool) {
        let first = kept.iter().find(|row| self.has(row));
        let (robot, task) = (&self.robot.name, self.task.name());
        let first = first.unwrap_or_else(|| panic!("golden has no {task} by {robot}"));
        let seed: u64 = first["seed"].parse().expect("a seed");
        assert_eq!(seeds::purpose(seed, 1), "judging");
        let baselines = match baselines {
            true => GripPolicy::baselines(self.task, None).to_vec(),
            false => Vec::new(),
        };
        let plan = Plan {
            robot: self.robot,
            skin: self.skin,
            task: self.task,
            objects: vec![Object::built_in(&first["object"]).expect("built in")],
            trials: 1,
            first_seed: seed,
            conditions: vec![self.condition],
            baselines,
            compare_everywhere: false,
            engine: None,
            threads: 0,
            settings: atas_core::Settings::default(),
        };
        let evaluated = plan.run(&AtomicBool::new(false), || ());
        let rows = evaluated.expect("it runs").expect("not stopped").rows;
        for today in written(&rows.concat()) {
            let same = |row: &&Columns| KEY.iter().all(|name| row[*name] == today[*name]);
            let then = kept.iter().find(same);
            assert_eq!(
                Some(&today),
                then,
                "the result differs from the golden file; measure again if the change is intended"
            );
        }
    }
}

#[test]
fn table_trials_reproduce() {
    let kept = columns(golden("all.csv").as_bytes());
    for task in Task::ALL {
        // Assembly baselines are too slow for this test.
        let usual = conditions(task).swap_remove(0);
        Series::usual(task, usual).check(&kept, task != Task::Assembly);
    }
}

#[test]
fn slow_sensor_trials_reproduce() {
    let kept = columns(golden("all.csv").as_bytes());
    for task in [Task::Grasp, Task::PickPlace] {
        let slow = conditions(task).into_iter().filter(|c| c.rate_hz < 1000);
        for condition in slow {
            Series::usual(task, condition).check(&kept, false);
        }
    }
}

#[test]
fn error_trials_reproduce() {
    let kept = columns(golden("errors.csv").as_bytes());
    for task in [Task::Grasp, Task::PickPlace, Task::Screw] {
        for condition in error_conditions(task) {
            Series::usual(task, condition).check(&kept, false);
        }
    }
}

#[test]
fn robot_and_skin_trials_reproduce() {
    let kept = columns(golden("robots.csv").as_bytes());
    let others = SHIPPED.into_iter().filter(|r| r.name != TWO_HAND_ARM.name);
    for robot in others {
        Series::grasp(robot, None).check(&kept, false);
    }
    let kept = columns(golden("skins.csv").as_bytes());
    let skins: BTreeSet<&str> = kept.iter().map(|row| row["skin"].as_str()).collect();
    assert!(skins.len() > 1, "{skins:?}");
    for skin in skins {
        Series::grasp(TWO_HAND_ARM, Some(skin)).check(&kept, false);
    }
}
