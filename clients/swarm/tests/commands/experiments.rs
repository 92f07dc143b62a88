//! Experiments: output, shards, threads and verification of files.

use super::*;

#[test]
fn experiment_prints_documented_fields() {
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
fn threads_engines_and_shards_give_same_files() {
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
    run(folder, "merge merged part1 part2 part3");
    assert_eq!(results(folder, "merged"), whole, "sharded and merged");
    assert!(
        run(folder, "merge merged part1").contains("preset N, fitness rule anti-accident: 3 runs")
    );
}

#[test]
fn incomplete_merge_fails_and_names_the_shard() {
    let folder = folder();
    let folder = folder.path();
    for shard in 1..=3 {
        run(
            folder,
            &format!("{SMALL} --out part{shard} --shard {shard}/3"),
        );
    }
    let message = refused(folder, "merge merged part1 part3", 7);
    assert!(
        message.contains("it lacks shard 2/3 (4 of 12 runs)"),
        "{message}"
    );
    assert!(
        !folder.join("merged/runs.csv").exists(),
        "no results of an incomplete merge"
    );

    let partial = output(folder, "merge --partial merged part1 --format json");
    assert!(partial.status.success(), "{partial:?}");
    let message = String::from_utf8_lossy(&partial.stderr);
    assert!(
        message.contains("merged lacks shard 2/3 (4 of 12 runs)"),
        "{message}"
    );

    // The missing runs of an interrupted shard are listed by team size and seed.
    let runs = folder.join("part2/runs.jsonl");
    let whole = std::fs::read_to_string(&runs).expect("runs");
    let short: String = whole.split_inclusive('\n').skip(1).collect();
    std::fs::write(&runs, short).expect("a writable file");
    let message = refused(folder, "merge merged part2", 7);
    assert!(message.contains("1 of 12 runs (agents"), "{message}");
    std::fs::write(&runs, whole).expect("a writable file");
    run(folder, "merge merged part2");
}

#[test]
fn forged_runs_are_rejected() {
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
            "is damaged",
        ),
        (
            resealed(&|run| run["agents"] = 7.into()),
            "its hash does not match",
        ),
        (
            resealed(&|run| run["points"][0] = 100.into()),
            "its hash does not match",
        ),
        (
            resealed(&|run| run["genome"] = "0".repeat(32).into()),
            "its hash does not match",
        ),
        (foreign.to_owned(), "its hash does not match"),
        (format!("{first}\n{first}"), "it repeats an earlier run"),
        ("{}".to_owned(), "missing field"),
    ];
    for (line, expected) in rows {
        std::fs::write(&runs, intact.replacen(&first, &line, 1)).expect("a writable file");
        for command in [
            format!("{SMALL} --out here"),
            "analyse here".to_owned(),
            "merge m here".to_owned(),
        ] {
            let message = refused(folder, &command, 7);
            assert!(
                message.contains(expected),
                "{command}: {message:?} does not contain {expected:?}"
            );
        }
    }
    std::fs::write(&runs, intact).expect("a writable file");
    run(folder, "analyse here --random-tables 1");
}

#[test]
fn merging_different_experiments_is_rejected() {
    let folder = folder();
    let folder = folder.path();
    run(folder, &format!("{SMALL} --out a --shard 1/2"));
    run(
        folder,
        "experiment fig14 --preset LB --seeds 3 --generations 40 --out b --shard 2/2",
    );
    assert!(refused(folder, "merge c a b", 7).contains("its preset is"));
    assert!(
        refused(folder, "merge c nowhere", 7).contains("could not read nowhere/experiment.toml")
    );
}

#[test]
fn experiment_is_analysed_and_plotted() {
    let folder = folder();
    let folder = folder.path();
    run(folder, &format!("{SMALL} --out here"));
    let analysis = json(folder, "analyse here --random-tables 20 --format json");
    assert_eq!(keys(&analysis), BTreeSet::from(["findings", "comparisons"]));
    assert_eq!(analysis["comparisons"].as_array().map(Vec::len), Some(4));
    assert!(run(folder, "analyse here --random-tables 20").contains("held out"));
    assert!(run(folder, "plot here").contains("fig14.svg"));
}

/// The scripts work without a scheduler: every shard, one of them twice, and the merge.
#[test]
fn cluster_scripts_give_the_bytes_of_one_run() {
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

    // Commands of the pods, with this program in place of the image.
    std::fs::rename(folder.join("it's"), folder.join("slurm's")).expect("a folder");
    std::fs::create_dir(folder.join("it's")).expect("an empty volume");
    let program = Path::new(env!("CARGO_BIN_EXE_ebts")).parent();
    let search = format!("{}:/usr/bin:/bin", program.expect("a folder").display());
    for (manifest, pods) in [("job.json", 0..3), ("merge.json", 0..1)] {
        let text = std::fs::read_to_string(folder.join("slurm's").join(manifest));
        let job: Value = serde_json::from_str(&text.expect("a manifest")).expect("JSON");
        let container = &job["spec"]["template"]["spec"]["containers"][0];
        let words: Vec<&str> = container["command"]
            .as_array()
            .expect("a command")
            .iter()
            .filter_map(Value::as_str)
            .collect();
        for pod in pods {
            let mut command = Command::new(words[0]);
            command
                .args(&words[1..])
                .current_dir(container["workingDir"].as_str().expect("a folder"))
                .env("PATH", &search)
                .env("JOB_COMPLETION_INDEX", format!("{pod}"));
            let output = command.output().expect("sh starts");
            assert!(output.status.success(), "{manifest}: {output:?}");
        }
    }
    assert_eq!(results(folder, "it's/whole"), results(folder, "whole"));
    let message = refused(folder, "slurm --shards 2 --out x -- fig14 --preset R9", 7);
    assert!(message.contains("neither a preset nor a file"), "{message}");
}
