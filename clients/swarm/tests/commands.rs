//! The program itself: what it prints, what it refuses, what it never loses.

use std::collections::BTreeSet;
use std::path::Path;
use std::process::{Command, Output, Stdio};
use std::time::Duration;

use serde_json::Value;
use tempfile::TempDir;

fn folder() -> TempDir {
    tempfile::tempdir().expect("a temporary folder")
}

fn ebts(folder: &Path, arguments: &str) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_ebts"));
    command
        .current_dir(folder)
        .args(arguments.split_whitespace());
    command
}

fn output(folder: &Path, arguments: &str) -> Output {
    ebts(folder, arguments).output().expect("ebts starts")
}

/// Runs a command that has to succeed; returns its standard output.
fn run(folder: &Path, arguments: &str) -> String {
    let output = output(folder, arguments);
    assert!(
        output.status.success(),
        "{arguments}: {}",
        String::from_utf8_lossy(&output.stderr)
    );
    String::from_utf8(output.stdout).expect("text")
}

fn json(folder: &Path, arguments: &str) -> Value {
    serde_json::from_str(&run(folder, arguments)).expect("JSON")
}

/// Runs a command that has to fail with this exit code; returns what it says.
fn refused(folder: &Path, arguments: &str, code: i32) -> String {
    let output = output(folder, arguments);
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(code), "{arguments}: {said}");
    said
}

/// Everything that follows from the runs of an experiment.
fn results(folder: &Path, name: &str) -> Vec<(String, String)> {
    let files = [
        "runs.csv",
        "curves.csv",
        "findings.json",
        "best-1.toml",
        "best-4.toml",
        "fig14.svg",
    ];
    let read =
        |file: &str| std::fs::read_to_string(folder.join(name).join(file)).expect("a result file");
    files.map(|file| (file.to_owned(), read(file))).to_vec()
}

fn keys(value: &Value) -> BTreeSet<&str> {
    value
        .as_object()
        .expect("an object")
        .keys()
        .map(String::as_str)
        .collect()
}

const SMALL: &str = "experiment fig14 --preset N --seeds 3 --generations 40";

#[test]
fn an_experiment_prints_its_documented_fields() {
    let folder = folder();
    let summary = json(folder.path(), &format!("{SMALL} --format json"));
    let fields = [
        "preset",
        "fitness_rule",
        "seeds",
        "generations",
        "wall_s",
        "cpu_s",
        "conditions",
        "p_order",
    ];
    assert_eq!(keys(&summary), BTreeSet::from(fields));
    let order = [
        "three_gt_four",
        "two_gt_four",
        "three_gt_two",
        "multi_ge_5x_single",
    ];
    assert_eq!(keys(&summary["p_order"]), BTreeSet::from(order));
    assert_eq!(summary["conditions"].as_array().map(Vec::len), Some(4));
    for (agents, condition) in (1..).zip(summary["conditions"].as_array().expect("a list")) {
        assert_eq!(
            keys(condition),
            BTreeSet::from(["agents", "q1", "median", "q3", "mean"])
        );
        assert_eq!(condition["agents"], agents);
        assert!(
            condition["median"]
                .as_f64()
                .is_some_and(|median| median > 0.0 && median <= 800.0)
        );
    }
    assert_eq!(
        (&summary["preset"], &summary["seeds"]),
        (&Value::from("N"), &Value::from(3))
    );
    assert!(folder.path().join("fig14-N-3x40/fig14.svg").exists());
}

#[test]
fn threads_engines_shards_and_repetition_change_no_byte() {
    let folder = folder();
    let folder = folder.path();
    run(folder, &format!("{SMALL} --out whole"));
    let whole = results(folder, "whole");
    run(folder, &format!("{SMALL} --out whole"));
    assert_eq!(results(folder, "whole"), whole, "run again");
    for (name, flags) in [
        ("one", "--threads 1"),
        ("three", "--threads 3"),
        ("portable", "--engine portable"),
    ] {
        run(folder, &format!("{SMALL} --out {name} {flags}"));
        assert_eq!(results(folder, name), whole, "{flags}");
    }
    for shard in 1..=3 {
        run(
            folder,
            &format!("{SMALL} --out part{shard} --shard {shard}/3"),
        );
    }
    let partial = run(folder, "merge merged part1 part3");
    assert!(partial.contains("4 runs are missing"), "{partial}");
    run(folder, "merge merged part2 part1");
    assert_eq!(results(folder, "merged"), whole, "sharded and merged");
    assert!(
        run(folder, "merge merged part1").contains("preset N, fitness rule anti-accident: 3 runs")
    );
}

#[test]
fn an_interrupted_experiment_goes_on_to_the_same_bytes() {
    const LONGER: &str = "experiment fig14 --preset N --seeds 12 --generations 150 --threads 1";
    let folder = folder();
    let folder = folder.path();
    run(folder, &format!("{LONGER} --out straight"));
    let mut child = ebts(folder, &format!("{LONGER} --out cut"))
        .stderr(Stdio::null())
        .spawn()
        .expect("ebts starts");
    let runs = folder.join("cut/runs.jsonl");
    while std::fs::metadata(&runs).map_or(0, |file| file.len()) == 0
        && child.try_wait().expect("a child").is_none()
    {
        std::thread::sleep(Duration::from_millis(5));
    }
    interrupt(child.id());
    let code = child.wait().expect("a child").code();
    assert!(matches!(code, Some(130 | 0)), "{code:?}");
    // A power cut may leave half a line behind.
    let mut torn = std::fs::read(&runs).expect("runs");
    torn.extend_from_slice(b"{\"agents\":4,\"se");
    std::fs::write(&runs, torn).expect("a writable file");
    run(folder, &format!("{LONGER} --out cut"));
    assert_eq!(results(folder, "cut"), results(folder, "straight"));
    assert!(
        !folder.join("cut/under-way").exists(),
        "nothing is under way any more"
    );
}

/// One generation of this population takes many seconds: it is broken off, and what was before it is saved.
#[test]
fn a_generation_of_a_huge_population_stops_too() {
    let folder = folder();
    let mut child = ebts(
        folder.path(),
        "evolve --population 10000 --islands 100 --agents 4 --engine scalar --threads 1 --out huge.toml",
    )
    .stderr(Stdio::null())
    .spawn()
    .expect("ebts starts");
    std::thread::sleep(Duration::from_millis(500));
    interrupt(child.id());
    assert_eq!(child.wait().expect("a child").code(), Some(130));
    let left = std::fs::read_dir(folder.path()).expect("a folder").count();
    assert_eq!(left, 0, "nothing was evaluated, so nothing is saved");
}

/// What somebody writes into `runs.jsonl`, and what is said of it.
#[test]
fn forged_runs_are_refused() {
    let folder = folder();
    let folder = folder.path();
    run(folder, &format!("{SMALL} --out here"));
    run(folder, &format!("{SMALL} --out other --first-seed 2"));
    let runs = folder.join("here/runs.jsonl");
    let intact = std::fs::read_to_string(&runs).expect("runs");
    let first = intact.lines().next().expect("a run").to_owned();
    let resealed = |change: &dyn Fn(&mut Value)| {
        let mut line: Value = serde_json::from_str(&first).expect("JSON");
        change(&mut line["run"]);
        line.to_string()
    };
    let foreign = std::fs::read_to_string(folder.join("other/runs.jsonl")).expect("runs");
    let foreign = foreign.lines().next().expect("a run");
    let rows = [
        (
            first.replacen("\"fitness\":", "\"fitness\":1e30,\"f\":", 1),
            "was damaged",
        ),
        (resealed(&|run| run["agents"] = 7.into()), "seal"),
        (resealed(&|run| run["points"][0] = 100.into()), "seal"),
        (
            resealed(&|run| run["genome"] = "0".repeat(32).into()),
            "seal",
        ),
        (foreign.to_owned(), "seal"),
        (format!("{first}\n{first}"), "this run was there before"),
        ("{}".to_owned(), "missing field"),
    ];
    for (line, expected) in rows {
        std::fs::write(&runs, intact.replacen(&first, &line, 1)).expect("a writable file");
        for command in [
            format!("{SMALL} --out here"),
            "analyse here".to_owned(),
            "merge m here".to_owned(),
        ] {
            let said = refused(folder, &command, 3);
            assert!(
                said.contains(expected),
                "{command}: {said:?} does not say {expected:?}"
            );
        }
    }
    std::fs::write(&runs, intact).expect("a writable file");
    run(folder, "analyse here --random-tables 1");
}

#[test]
fn an_interrupted_run_goes_on_to_the_same_table() {
    const EVOLVE: &str = "evolve --preset N --agents 4 --seed 11 --generations 3000 --islands 2";
    let folder = folder();
    let folder = folder.path();
    run(folder, &format!("{EVOLVE} --out straight.toml"));
    let mut child = ebts(folder, &format!("{EVOLVE} --out cut.toml"))
        .stderr(Stdio::null())
        .spawn()
        .expect("ebts starts");
    std::thread::sleep(Duration::from_millis(150));
    interrupt(child.id());
    if child.wait().expect("a child").code() == Some(130) {
        assert!(!folder.join("cut.toml").exists(), "no table before the end");
        refused(folder, &format!("{EVOLVE} --out cut.toml"), 3);
        run(folder, "evolve --out cut.toml --resume");
    }
    let table = |name: &str| std::fs::read_to_string(folder.join(name)).expect("a table");
    assert_eq!(table("cut.toml"), table("straight.toml"));
    assert!(!folder.join("cut.toml.checkpoint").exists());
    assert!(refused(folder, &format!("{EVOLVE} --out cut.toml"), 3).contains("is there already"));
}

fn interrupt(process: u32) {
    let status = Command::new("kill")
        .args(["-INT", &process.to_string()])
        .status();
    assert!(status.is_ok(), "kill is there");
}

/// A limit on the size of files stands in for a full disk: writing fails half-way.
#[test]
fn a_full_disk_loses_nothing_that_was_finished() {
    let folder = folder();
    let folder = folder.path();
    run(folder, &format!("{SMALL} --out straight"));
    let limited = format!(
        "trap '' XFSZ; ulimit -f 2; exec {} {SMALL} --threads 1 --out full",
        env!("CARGO_BIN_EXE_ebts")
    );
    let output = Command::new("bash")
        .current_dir(folder)
        .args(["-c", &limited])
        .output()
        .expect("bash starts");
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(5), "{said}");
    assert!(
        said.contains("free some and run the same command again"),
        "{said}"
    );
    let kept = std::fs::read_to_string(folder.join("full/runs.jsonl")).expect("runs");
    assert!(
        kept.ends_with('\n') && kept.lines().count() >= 1,
        "whole lines: {kept:?}"
    );
    run(folder, &format!("{SMALL} --out full"));
    let after = std::fs::read_to_string(folder.join("full/runs.jsonl")).expect("runs");
    assert!(after.starts_with(&kept), "finished runs stay");
    assert_eq!(results(folder, "full"), results(folder, "straight"));
}

#[test]
fn one_folder_holds_one_experiment_at_a_time() {
    let folder = folder();
    let folder = folder.path();
    run(folder, &format!("{SMALL} --out here"));
    let said = refused(
        folder,
        "experiment fig14 --preset N --seeds 3 --generations 41 --out here",
        3,
    );
    assert!(said.contains("its generations was 40, needs 41"), "{said}");
    let lock = std::fs::File::open(folder.join("here/.lock")).expect("the lock file");
    lock.try_lock().expect("a free lock");
    assert!(
        refused(folder, &format!("{SMALL} --out here"), 4).contains("another ebts works on it")
    );
    drop(lock);
    run(folder, &format!("{SMALL} --out here"));
    std::fs::write(folder.join("here/runs.jsonl"), "not a run\n").expect("a writable file");
    assert!(refused(folder, &format!("{SMALL} --out here"), 3).contains("line 1 was damaged"));
}

#[test]
fn merging_different_experiments_is_refused() {
    let folder = folder();
    let folder = folder.path();
    run(folder, &format!("{SMALL} --out a --shard 1/2"));
    run(
        folder,
        "experiment fig14 --preset LB --seeds 3 --generations 40 --out b --shard 2/2",
    );
    assert!(refused(folder, "merge c a b", 3).contains("its preset was"));
    assert!(
        refused(folder, "merge c nowhere", 3).contains("could not read nowhere/experiment.toml")
    );
}

#[test]
fn a_table_can_be_shown_drawn_replayed_and_edited() {
    let folder = folder();
    let folder = folder.path();
    run(
        folder,
        "evolve --agents 2 --generations 60 --seed 2 --out t.toml",
    );
    let shown = json(folder, "show t.toml --format json");
    assert_eq!(
        (&shown["fitness_repeats"], &shown["edited"]),
        (&Value::from(true), &Value::from(false))
    );
    assert_eq!(shown["tables"][0].as_array().map(Vec::len), Some(32));
    assert!(run(folder, "show t.toml").contains("Go straight"));
    assert!(run(folder, "plot t.toml --goal 3").contains("  250      2"));
    for file in ["t.trajectories.svg", "t.behaviour-3.svg"] {
        assert!(
            std::fs::read_to_string(folder.join(file))
                .expect("a figure")
                .starts_with("<svg")
        );
    }
    run(folder, "replay t.toml");
    let page = std::fs::read_to_string(folder.join("t.html")).expect("a page");
    assert!(
        page.contains("\"trials\":[{") && !page.contains("/*DATA*/"),
        "the data are in the page"
    );
    assert!(!page.contains("http"), "the page needs nothing else");

    let text = std::fs::read_to_string(folder.join("t.toml")).expect("a table");
    let edited: String = text
        .lines()
        .map(|line| {
            if line.contains("\"00011 ") {
                "\"00011 11 11\",\n".to_owned()
            } else {
                format!("{line}\n")
            }
        })
        .collect();
    std::fs::write(folder.join("t.toml"), edited).expect("a writable file");
    for command in ["show", "plot", "replay"] {
        assert!(
            refused(folder, &format!("{command} t.toml"), 3).contains("--rehash"),
            "{command}"
        );
    }
    run(folder, "show t.toml --rehash");
    let shown = json(folder, "show t.toml --format json");
    assert_eq!(
        (&shown["fitness_repeats"], &shown["edited"]),
        (&Value::from(true), &Value::from(true))
    );
}

#[test]
fn an_experiment_can_be_analysed_and_drawn_again() {
    let folder = folder();
    let folder = folder.path();
    run(folder, &format!("{SMALL} --out here"));
    let analysis = json(folder, "analyse here --random-tables 20 --format json");
    assert_eq!(keys(&analysis), BTreeSet::from(["findings", "comparisons"]));
    assert_eq!(analysis["comparisons"].as_array().map(Vec::len), Some(4));
    assert!(run(folder, "analyse here --random-tables 20").contains("held out"));
    assert!(run(folder, "plot here").contains("fig14.svg"));
}

#[test]
fn a_researcher_gets_trials_examples_comparisons_and_sweeps() {
    let folder = folder();
    let folder = folder.path();
    run(
        folder,
        "experiment fig14 --preset LB --seeds 4 --generations 60 --agents 4 --out here",
    );
    let exported = json(folder, "export here --format json");
    assert_eq!(exported["trials"], 32);
    let csv = std::fs::read_to_string(folder.join("here/trials.csv")).expect("trials");
    assert!(
        csv.starts_with("agents,seed,goal,points,delivered,"),
        "{csv}"
    );
    assert_eq!(csv.lines().count(), 33);
    let found = json(folder, "find here --format json");
    let delivered = csv.lines().filter(|line| line.contains(",true,")).count();
    let examples: u64 = found
        .as_array()
        .expect("cases")
        .iter()
        .filter_map(|c| c["trials"].as_u64())
        .sum();
    assert!(examples as usize <= delivered, "{found}");
    let compared = run(folder, "compare here here");
    assert!(compared.contains("| LB, anti-accident, 4 |"), "{compared}");
    assert!(
        compared.contains("not run"),
        "findings need other team sizes: {compared}"
    );

    let swept = json(
        folder,
        "sweep --preset LB --vary goal_radius_px=20,40 --vary friction_per_stall_force=0.9 --agents 2 --seeds 2 \
         --generations 20 --out s --format json",
    );
    assert_eq!(swept.as_array().map(Vec::len), Some(2));
    for combination in swept.as_array().expect("combinations") {
        let place = combination["folder"].as_str().expect("a folder");
        assert!(folder.join(place).join("summary.json").exists(), "{place}");
    }
    run(
        folder,
        "evolve --preset LB3 --fitness compared --generations 5 --out t.toml --history h.csv",
    );
    let history = std::fs::read_to_string(folder.join("h.csv")).expect("a history");
    assert!(
        history.starts_with("generation,best,mean,worst,diversity\n0,"),
        "{history}"
    );
    assert_eq!(history.lines().count(), 7);
    assert_eq!(
        json(folder, "show t.toml --format json")["fitness_rule"],
        "compared"
    );
}

/// The scripts do what they say without a scheduler too: every shard, one of them twice, and the merge.
#[test]
fn scripts_for_a_cluster_give_the_bytes_of_one_run() {
    let folder = folder();
    let folder = folder.path();
    run(folder, &format!("{SMALL} --out whole"));
    let small = SMALL.trim_start_matches("experiment ");
    let written = json(
        folder,
        &format!("slurm --shards 3 --out it's --format json -- {small}"),
    );
    assert_eq!(
        (&written["runs"], &written["scripts"][0]),
        (&12.into(), &"it's/shard.sh".into())
    );
    let bash = |script: &str, variables: &[(&str, &str)]| {
        let mut bash = Command::new("bash");
        bash.current_dir(folder)
            .arg(folder.join("it's").join(script))
            .envs(variables.iter().copied());
        let output = bash.output().expect("bash starts");
        assert!(
            output.status.success(),
            "{script}: {}",
            String::from_utf8_lossy(&output.stderr)
        );
    };
    for task in ["1", "2", "3", "2"] {
        bash(
            "array.sbatch",
            &[("SLURM_ARRAY_TASK_ID", task), ("SLURM_JOB_ID", "1")],
        );
    }
    bash("merge.sbatch", &[]);
    assert_eq!(results(folder, "it's/whole"), results(folder, "whole"));
    let said = refused(folder, "slurm --shards 2 --out x -- fig14 --preset R9", 3);
    assert!(said.contains("neither a preset nor a file"), "{said}");
}

#[test]
fn presets_are_printed_completed_and_stay_inside() {
    let folder = folder();
    let folder = folder.path();
    assert!(run(folder, "preset").contains("LB3"));
    std::fs::write(folder.join("r3.toml"), run(folder, "preset R3")).expect("a writable file");
    run(
        folder,
        "evolve --preset r3.toml --generations 3 --out a.toml",
    );
    run(folder, "evolve --preset R3 --generations 3 --out b.toml");
    let table = |name: &str| std::fs::read_to_string(folder.join(name)).expect("a table");
    assert_eq!(table("a.toml"), table("b.toml"));
    let inside = folder.join("inside");
    std::fs::create_dir(&inside).expect("a folder");
    let partial = "base = \"R3\"\nname = \"../../outside\"\nfriction_per_stall_force = 0.9\n";
    std::fs::write(inside.join("p.toml"), partial).expect("a writable file");
    run(
        &inside,
        "experiment fig14 --preset p.toml --seeds 1 --generations 1 --agents 1",
    );
    let mut made: Vec<_> = std::fs::read_dir(folder)
        .expect("the folder")
        .filter_map(|entry| entry.ok()?.file_name().into_string().ok())
        .collect();
    made.sort();
    assert_eq!(
        made,
        ["a.toml", "b.toml", "inside", "r3.toml"],
        "nothing outside"
    );
}

#[test]
fn completions_manual_pages_and_help_are_there() {
    let folder = folder();
    let folder = folder.path();
    for shell in ["bash", "zsh", "fish"] {
        assert!(run(folder, &format!("completions {shell}")).contains("experiment"));
    }
    run(folder, "man pages");
    assert!(folder.join("pages/ebts-sweep.1").exists());
    let commands = [
        "evolve",
        "experiment",
        "sweep",
        "merge",
        "analyse",
        "compare",
        "export",
        "find",
        "preset",
        "plot",
        "show",
        "agents",
        "replay",
        "completions",
        "man",
        "slurm",
    ];
    for command in commands {
        let help = run(folder, &format!("{command} --help"));
        assert!(help.contains("Example"), "{command}: {help}");
        assert!(help.contains("--format"), "{command}: {help}");
    }
}

/// A reader that goes away ends nothing in anger; a full disk is told.
#[test]
fn closed_pipes_and_full_disks_are_no_panic() {
    let folder = folder();
    for arguments in [
        "preset",
        "preset R3",
        "completions bash",
        "--help",
        "preset --format json",
    ] {
        let command = format!("{} {arguments}", env!("CARGO_BIN_EXE_ebts"));
        let shell = |script: String| {
            let mut shell = Command::new("bash");
            shell
                .current_dir(folder.path())
                .args(["-c", &script])
                .output()
                .expect("bash starts")
        };
        let closed = shell(format!("{command} | true; exit ${{PIPESTATUS[0]}}"));
        let said = String::from_utf8_lossy(&closed.stderr).into_owned();
        assert_eq!(
            (closed.status.code(), said.as_str()),
            (Some(0), ""),
            "{arguments}"
        );
        let full = shell(format!("{command} > /dev/full"));
        let said = String::from_utf8_lossy(&full.stderr);
        assert!(!said.contains("panicked"), "{arguments}: {said}");
        if arguments != "--help" {
            assert_eq!(full.status.code(), Some(5), "{arguments}: {said}");
        }
    }
}

#[test]
fn tables_fit_into_80_columns() {
    let folder = folder();
    let folder = folder.path();
    let printed = [
        run(folder, &format!("{SMALL} --out here")),
        run(folder, "analyse here --random-tables 1000"),
        run(folder, "find here"),
        run(folder, "preset"),
        run(folder, "evolve --generations 20 --out t.toml"),
        run(folder, "show t.toml"),
        run(folder, "plot t.toml"),
    ];
    for line in printed.iter().flat_map(|text| text.lines()) {
        assert!(
            line.chars().count() <= 80,
            "{} columns: {line}",
            line.chars().count()
        );
    }
}

#[test]
fn what_makes_no_sense_is_refused_before_anything_is_written() {
    let folder = folder();
    let folder = folder.path();
    std::fs::write(folder.join("bad.toml"), "name = \"bad\"\n").expect("a writable file");
    let rows = [
        ("evolve --agents 0", 3, "could not place 0 agents"),
        ("evolve --preset R9", 3, "neither a preset nor a file"),
        ("evolve --preset bad.toml", 3, "missing field"),
        ("evolve --population 7", 3, "population because it was 7"),
        ("evolve --elite 10", 3, "elite because it was 10"),
        ("evolve --elite 0", 3, "elite because it was 0"),
        ("experiment fig14 --agents 2,2", 3, "each once"),
        ("experiment fig14 --agents 5", 3, "could not place 5 agents"),
        ("sweep --vary speed=1", 3, "unknown field `speed`"),
        ("sweep --vary goal_radius_px", 2, "goal_radius_px=40,50"),
        ("preset R9", 3, "neither a preset nor a file"),
        (
            "evolve --mutation-rate nan",
            3,
            "mutation_rate because it was NaN",
        ),
        (
            "evolve --engine abacus",
            3,
            "could not use engine \"abacus\"",
        ),
        ("evolve --sensors ir-left", 2, "permutation"),
        ("evolve --resume", 3, "could not read table.toml.checkpoint"),
        ("experiment fig14 --shard 4/3", 2, "needs i/n"),
        ("experiment fig15", 2, "fig15"),
        ("show missing.toml", 3, "could not read missing.toml"),
        ("show bad.toml", 3, "it is no table file"),
        ("plot missing", 3, "could not read missing"),
    ];
    for (arguments, code, expected) in rows {
        let said = refused(folder, arguments, code);
        assert!(
            said.contains(expected),
            "{arguments}: {said:?} does not say {expected:?}"
        );
    }
    let left: Vec<_> = std::fs::read_dir(folder)
        .expect("the folder")
        .filter_map(Result::ok)
        .map(|e| e.file_name())
        .collect();
    assert_eq!(left, ["bad.toml"]);
}
