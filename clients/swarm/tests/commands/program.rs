//! Presets, help, pipes, column widths and invalid arguments.

use super::*;

#[test]
fn presets_round_trip_and_stay_in_folder() {
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
        "no file outside"
    );
}

#[test]
fn completions_manual_and_help_exist() {
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
        "search",
        "transfer",
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
        assert!(help.contains("With --format json:"), "{command}: {help}");
    }
}

fn all_keys(value: &Value) -> BTreeSet<&str> {
    match value {
        Value::Array(values) => values.iter().flat_map(all_keys).collect(),
        Value::Object(values) => {
            let below = values.values().flat_map(all_keys);
            values.keys().map(String::as_str).chain(below).collect()
        }
        _ => BTreeSet::new(),
    }
}

fn outermost_keys(value: &Value) -> BTreeSet<&str> {
    keys(value.get(0).unwrap_or(value))
}

#[test]
fn help_lists_json_fields() {
    let folder = folder();
    let folder = folder.path();
    // These are compared at any depth; those below only at the outermost level.
    let rows = [
        ("evolve", "--generations 3 --out t.toml"),
        ("show", "t.toml"),
        ("plot", "t.toml"),
        ("replay", "t.toml"),
        ("slurm", "--shards 2 --out big -- fig14 --seeds 4"),
        ("man", "pages"),
    ];
    let first = [
        (SMALL, "--out a"),
        ("merge", "whole a"),
        ("analyse", "a --random-tables 10"),
        ("transfer", "a"),
        ("compare", "a"),
        ("export", "a"),
        ("find", "a"),
        ("preset", ""),
        (
            "sweep",
            "--vary goal_radius_px=40 --seeds 1 --generations 2 --out s",
        ),
        (
            "search",
            "--vary goal_radius_px=40.0..60.0 --candidates 2 --best 1 --seeds 1 --generations 2 --verdict-seeds 2",
        ),
        ("evolve course", "--generations 1 --out c.toml"),
    ];
    let check = |(command, more): (&str, &str), depth: fn(&Value) -> BTreeSet<&str>| {
        let verb = command.split(" --").next().unwrap_or(command);
        let verb = verb.trim_end_matches(" fig14");
        let help = run(folder, &format!("{verb} --help"));
        let printed = json(folder, &format!("{command} --format json {more}"));
        let keys = depth(&printed);
        assert!(!keys.is_empty(), "{command}: {printed}");
        for key in keys {
            assert!(help.contains(key), "{command}: {key} is not in {help}");
        }
    };
    rows.into_iter().for_each(|row| check(row, all_keys));
    first.into_iter().for_each(|row| check(row, outermost_keys));
}

#[test]
fn errors_are_json_with_json_format() {
    let folder = folder();
    for (arguments, code, part) in [
        ("show missing.toml --format json", 7, "missing.toml"),
        ("--format=json preset R9", 7, "neither a preset nor a file"),
        ("fly --format json", 2, "unrecognized subcommand"),
        ("evolve --out x.json --format json", 2, ".toml"),
        (
            "agents --table missing.toml --format json",
            7,
            "missing.toml",
        ),
    ] {
        let message = refused(folder.path(), arguments, code);
        let error: Value = serde_json::from_str(&message).expect("one object");
        assert_eq!(error["exit"], code, "{arguments}: {message}");
        let sentence = error["error"].as_str().expect("a text");
        assert!(sentence.contains(part), "{arguments}: {message}");
    }
}

/// A closed reader is not an error; a full disk is reported.
#[test]
fn closed_pipe_and_full_disk_do_not_panic() {
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
        let message = String::from_utf8_lossy(&closed.stderr).into_owned();
        assert_eq!(
            (closed.status.code(), message.as_str()),
            (Some(0), ""),
            "{arguments}"
        );
        let full = shell(format!("{command} > /dev/full"));
        let message = String::from_utf8_lossy(&full.stderr);
        assert!(!message.contains("panicked"), "{arguments}: {message}");
        assert_eq!(full.status.code(), Some(1), "{arguments}: {message}");
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
        run(folder, "transfer here"),
        run(
            folder,
            "search --vary goal_radius_px=40.0..60.0 --candidates 2 --best 1 --seeds 1 --generations 2 --verdict-seeds 2",
        ),
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
fn invalid_arguments_are_rejected_before_writing() {
    let folder = folder();
    let folder = folder.path();
    let files = [
        ("bad.toml", "name = \"bad\"\n"),
        ("drawn.toml", "base = \"R3\"\ntraining = { draws = 65 }\n"),
        (
            "noisy.toml",
            "base = \"R3\"\nnoise = { wheel_slips_per_1024 = 1025 }\n",
        ),
    ];
    for (name, text) in files {
        std::fs::write(folder.join(name), text).expect("a writable file");
    }
    let rows = [
        ("evolve --agents 0", 7, "could not place 0 agents"),
        ("evolve --preset R9", 7, "neither a preset nor a file"),
        ("evolve --preset bad.toml", 7, "missing field"),
        ("evolve --population 7", 7, "population: it is 7"),
        ("evolve --elite 10", 7, "elite: it is 10"),
        ("evolve --elite 0", 7, "elite: it is 0"),
        ("experiment fig14 --agents 2,2", 7, "each once"),
        ("experiment fig14 --agents 5", 7, "could not place 5 agents"),
        ("sweep --vary speed=1", 7, "unknown field `speed`"),
        ("sweep --vary goal_radius_px", 2, "goal_radius_px=40,50"),
        ("search --vary goal_radius_px=9..1", 2, "40.0..60.0"),
        ("search --vary speed=1.0..2.0", 7, "unknown field `speed`"),
        (
            "search --vary ir_angle_steps=6..9 --find flying",
            2,
            "needs one of five-times",
        ),
        (
            "search --vary ir_angle_steps=6..9 --verdict-first-seed 1000001",
            7,
            "seeds outside 1000001",
        ),
        ("evolve --preset noisy.toml", 7, "0 to 1024"),
        ("evolve --preset drawn.toml", 7, "training.draws was 65"),
        ("transfer nothing", 7, "could not read nothing"),
        ("preset R9", 7, "neither a preset nor a file"),
        ("evolve --mutation-rate nan", 7, "mutation_rate: it is NaN"),
        (
            "evolve --engine abacus",
            7,
            "engine \"abacus\" not available",
        ),
        ("evolve --sensors ir-left", 2, "permutation"),
        ("evolve --out table.json", 2, "must end in .toml"),
        ("evolve --out table", 2, "must end in .toml"),
        ("evolve --history h.json", 2, "must end in .csv"),
        ("evolve grasp --out table.json", 2, "must end in .toml"),
        ("evolve course --out table.json", 2, "must end in .toml"),
        ("export here --out trials.json", 2, "must end in .csv"),
        ("find here --out fig17.png", 2, "must end in .svg"),
        ("replay bad.toml --out page.pdf", 2, "must end in .html"),
        (
            "evolve --resume",
            7,
            "table.toml.checkpoint: the file does not exist",
        ),
        ("experiment fig14 --shard 4/3", 2, "needs i/n"),
        ("experiment fig15", 2, "fig15"),
        ("show missing.toml", 7, "could not read missing.toml"),
        ("show bad.toml", 7, "it is not a table file"),
        ("plot missing", 7, "could not read missing"),
    ];
    for (arguments, code, expected) in rows {
        let message = refused(folder, arguments, code);
        assert!(
            message.contains(expected),
            "{arguments}: {message:?} does not contain {expected:?}"
        );
    }
    let mut left: Vec<_> = std::fs::read_dir(folder)
        .expect("the folder")
        .filter_map(Result::ok)
        .map(|e| e.file_name())
        .collect();
    left.sort();
    assert_eq!(left, files.map(|(name, _)| name));
}
