//! The laboratory's part as a process: exit codes, messages, and what it leaves behind.

use std::io::Write;
use std::path::Path;
use std::process::{Command, Output, Stdio};
use std::time::{Duration, Instant};

fn atas(arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_atas-lab"));
    command
        .args(arguments)
        .env_remove("ATAS_BUS")
        .env_remove("RUST_LOG")
        .stdin(Stdio::null());
    command
}

fn run(arguments: &[&str]) -> (i32, String, String) {
    let Output {
        status,
        stdout,
        stderr,
    } = atas(arguments).output().expect("it starts");
    let text = |bytes| String::from_utf8(bytes).expect("UTF-8");
    (status.code().expect("a code"), text(stdout), text(stderr))
}

#[test]
fn wrong_usage_has_its_own_code() {
    let check = |arguments: &[&str], part: &str| {
        let (code, _, stderr) = run(arguments);
        assert_eq!(code, 2, "{arguments:?}: {stderr}");
        assert!(stderr.contains(part), "{arguments:?}: {stderr}");
    };
    check(
        &["eval", "grasp", "--objects", "botle"],
        "did you mean \"bottle\"?",
    );
    check(&["demo", "grasp", "--object", "no/such.toml"], "no/such");
    check(
        &["demo", "pick-place", "--object", "no/such.toml"],
        "no/such",
    );
    check(&["demo", "screw", "--cap", "wood"], "has no thread");
    check(
        &["demo", "assembly", "--cap", "cup"],
        "did you mean \"cap\"?",
    );
    check(&["status"], "ask `atas` for it");
}

#[test]
fn a_picture_is_what_its_suffix_says_in_any_case() {
    let folder = tempfile::tempdir().expect("a folder");
    for (name, begins) in [
        ("a.svg", &b"<svg"[..]),
        ("b.SVG", b"<svg"),
        ("c.Png", b"\x89PNG"),
        ("d.PDF", b"%PDF"),
    ] {
        let file = folder.path().join(name);
        let out = file.to_str().expect("UTF-8");
        let (code, _, stderr) = run(&["plot", "grasp", "--object", "sponge", "--out", out]);
        assert_eq!(code, 0, "{name}: {stderr}");
        let bytes = std::fs::read(&file).expect("a picture");
        assert!(bytes.starts_with(begins), "{name}");
    }
}

#[test]
fn a_file_that_is_no_recording_is_told_as_such() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("tasks.toml");
    std::fs::write(&file, "[[task]]\nname = \"polish\"\n").expect("written");
    let path = file.to_str().expect("UTF-8");
    let out = format!("{path}.svg");
    for line in [
        &["explain", path][..],
        &["replay", path],
        &["plot", path, "--out", &out],
    ] {
        let (code, _, stderr) = run(line);
        assert_eq!(code, 1, "{line:?}: {stderr}");
        assert!(
            stderr.contains("does not begin as a recording does") && !stderr.contains("repair"),
            "{line:?}: {stderr}"
        );
    }
}

#[test]
fn eval_prints_one_json_line() {
    let (code, stdout, stderr) = run(&[
        "eval",
        "grasp",
        "--seeds",
        "1",
        "--objects",
        "sponge",
        "--format",
        "json",
    ]);
    assert_eq!(code, 0, "{stderr}");
    assert_eq!(stdout.lines().count(), 1, "{stdout}");
    let value: serde_json::Value = serde_json::from_str(&stdout).expect("JSON");
    assert_eq!(value["trials"], 1);
}

#[test]
fn parts_put_together_give_the_report_of_one_run() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = |name: &str| folder.path().join(name).to_str().expect("UTF-8").to_owned();
    let (one, two, whole) = (file("1.part"), file("2.part"), file("whole.csv"));
    let eval = |more: &[&str]| {
        let words =
            "eval grasp --trials 3 --objects sponge,wood --noise 1 --fixed-force 2 --format json";
        let words: Vec<&str> = words.split(' ').chain(more.iter().copied()).collect();
        run(&words)
    };
    let merge = |parts: &[&str]| {
        let rows = file("merged.csv");
        run(&[
            &["eval", "merge", "--format", "json", "--rows", &rows],
            parts,
        ]
        .concat())
    };
    assert_eq!(eval(&["--shard", "1/2", "--out", &one]).0, 0);
    let refused = |parts: &[&str], said: &str| {
        let (code, _, stderr) = merge(parts);
        assert_eq!(code, 1, "{parts:?}");
        assert!(stderr.contains(said), "{stderr}");
    };
    refused(&[&one], "part 2/2 is missing");
    refused(&[&one, &one], "part 1/2 is there twice");
    assert_eq!(eval(&["--shard", "2/2", "--out", &two]).0, 0);
    // A part whose last trial was cut off in writing goes on with that trial.
    let bytes = std::fs::read(&two).expect("readable");
    std::fs::write(&two, &bytes[..bytes.len() - 9]).expect("writable");
    refused(
        &[&one, &two],
        "2.part because it was damaged behind its trial 3",
    );
    let goes_on = |ran: u64| {
        let damaged = std::fs::read(&two).expect("readable");
        let (code, again, said) = eval(&["--shard", "2/2", "--out", &two]);
        let again: serde_json::Value = serde_json::from_str(&again).expect("JSON");
        assert_eq!((code, &again["ran"]), (0, &ran.into()), "{said}");
        assert!(
            said.contains("2.part was damaged behind its trial"),
            "{said}"
        );
        let kept = std::fs::read(format!("{two}.damaged")).expect("kept");
        assert!(kept == damaged, "as it was");
    };
    goes_on(1);
    // A bit that fell over is found, and its trial runs again.
    let mut flipped = std::fs::read(&two).expect("readable");
    *flipped.last_mut().expect("a trial") ^= 1;
    std::fs::write(&two, flipped).expect("writable");
    refused(&[&one, &two], "(its seal does not fit)");
    goes_on(1);
    let (code, _, other) = eval(&["--shard", "1/2", "--out", &two]);
    assert!(
        code == 1 && other.contains("part of another evaluation"),
        "{other}"
    );

    let report = |(code, stdout, stderr): (i32, String, String)| {
        assert_eq!(code, 0, "{stderr}");
        let mut report: serde_json::Value = serde_json::from_str(&stdout).expect("JSON");
        let times = ["wall_s", "realtime_factor"];
        let fields = report.as_object_mut().expect("an object");
        fields.retain(|name, _| !times.contains(&name.as_str()));
        report
    };
    assert_eq!(
        report(merge(&[&two, &one])),
        report(eval(&["--rows", &whole]))
    );
    let text = |name: &str| std::fs::read_to_string(file(name)).expect("readable");
    assert_eq!(text("merged.csv"), text("whole.csv"));
}

#[test]
fn a_program_without_its_neighbours_says_how_to_build_them() {
    let folder = tempfile::tempdir().expect("a folder");
    let alone = folder.path().join("atas-lab");
    std::fs::copy(env!("CARGO_BIN_EXE_atas-lab"), &alone).expect("copied");
    let output = Command::new(&alone)
        .args(["demo", "grasp"])
        .output()
        .expect("it starts");
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{stderr}");
    assert!(stderr.contains("cargo build --workspace"), "{stderr}");
}

/// Whether daemon and simulator lie next to the program; if not, they were not built in this run.
fn neighbours_are_built() -> bool {
    let folder = Path::new(env!("CARGO_BIN_EXE_atas-lab")).parent();
    let built = ["atasd", "atas-sim"]
        .iter()
        .all(|name| folder.is_some_and(|folder| folder.join(name).is_file()));
    if !built {
        let why = "atasd and atas-sim are not built; use `cargo test --workspace`";
        // Past the harness, which keeps what a passing test prints to itself.
        let _ = writeln!(std::io::stderr(), "SKIPPED: the demos' tests: {why}");
    }
    built
}

#[test]
fn an_interrupted_demo_leaves_nothing_behind() {
    if !neighbours_are_built() {
        return;
    }
    let scratch = tempfile::tempdir().expect("a folder");
    // Logs and bus of this demo, and of no other, in here.
    let demo = atas(&["demo", "grasp", "--object", "wood"])
        .env("TMPDIR", scratch.path())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("it starts");
    let id = demo.id();
    let bus = format!("fdemo-{id}-0");
    let begin = Instant::now();
    while children_of(id).len() < 2 && begin.elapsed() < Duration::from_secs(20) {
        std::thread::sleep(Duration::from_millis(5));
    }
    let children = children_of(id);
    assert_eq!(children.len(), 2, "simulator and daemon");
    let pid = rustix::process::Pid::from_child(&demo);
    rustix::process::kill_process(pid, rustix::process::Signal::INT).expect("it runs");
    let output = demo.wait_with_output().expect("it ends");
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(5), "{stderr}");
    for child in children {
        assert!(!Path::new(&format!("/proc/{child}")).exists(), "{child}");
    }
    let shared = std::fs::read_dir("/dev/shm").expect("shared memory");
    let left = shared
        .flatten()
        .filter(|entry| entry.file_name().to_string_lossy().starts_with(&bus));
    assert_eq!(left.count(), 0, "shared memory of {bus}");
    let logs = std::fs::read_dir(scratch.path()).expect("the folder");
    assert_eq!(logs.count(), 0, "logs");
}

/// Process ids of a process's children.
fn children_of(id: u32) -> Vec<u32> {
    let text = std::fs::read_to_string(format!("/proc/{id}/task/{id}/children"));
    let text = text.unwrap_or_default();
    text.split_whitespace()
        .filter_map(|id| id.parse().ok())
        .collect()
}

/// As wide as a table is where nobody says how wide the terminal is.
#[test]
fn tables_fit_eighty_columns_and_break_no_range() {
    if !neighbours_are_built() {
        return;
    }
    // What is below a table begins with `below`; a sentence may be as long as it is.
    let check = |line: &str, below: &str, parts: &[&str]| {
        let words: Vec<&str> = line.split(' ').collect();
        let (code, stdout, stderr) = run(&words);
        assert_eq!(code, 0, "{line}: {stderr}");
        for part in parts {
            assert!(stdout.contains(part), "{part:?} is not in: {stdout}");
        }
        for row in stdout.lines().take_while(|row| !row.starts_with(below)) {
            assert!(row.chars().count() <= 80, "{row}");
            assert!(!row.trim_end().ends_with(" to"), "{stdout}");
            assert!(!row.contains("reason"), "{stdout}");
        }
    };
    let demo = |task: &str, parts: &[&str]| {
        check(&format!("demo {task} --lockstep"), "heavy-block: ", parts);
    };
    demo("grasp --object wood", &["lifted mm", "held"]);
    demo(
        "grasp --object heavy-block",
        &[
            "refused:",
            "too heavy ",
            "\nheavy-block: lift: ",
            " N do not hold it, and ",
        ],
    );
    demo("pick-place --object wood", &["took", "placed"]);
    demo("screw", &["took s", "tight"]);
    check(
        "eval grasp --trials 2 --objects filled-paper-box,slippery-200 --noise 1",
        "grasp: ",
        &["1 of 1", "otherwise"],
    );
}

/// A fingertip of four electrodes, touched by one object and slipping on it.
fn slips() -> String {
    let mut text = "label,sequence,object,ff_e1,ff_e2,ff_e3,ff_e4\n".to_owned();
    for sequence in 0..8 {
        let (label, speed) = if sequence % 2 == 0 {
            ("t", 0)
        } else {
            ("n", 3)
        };
        for frame in 0..250 {
            let counts = |electrode: i32| {
                3000 + speed * frame * electrode + (frame * frame * 7 + electrode + sequence) % 11
            };
            let counts: Vec<String> = (1..=4).map(|e| counts(e).to_string()).collect();
            text += &format!(
                "{label},{sequence},cup{},{}\n",
                sequence / 2,
                counts.join(",")
            );
        }
    }
    text
}

#[test]
fn recordings_are_judged_as_one_json_line_and_refused_with_a_cure() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = |name: &str| folder.path().join(name).display().to_string();
    std::fs::write(path("slips.csv"), slips()).expect("written");
    let (file, model) = (path("slips.csv"), path("mine.toml"));
    let judge = |more: &[&str]| {
        let line = [&["eval", "recording", &file, "--format", "json"], more].concat();
        let (code, stdout, stderr) = run(&line);
        assert_eq!(code, 0, "{more:?}: {stderr}");
        serde_json::from_str::<serde_json::Value>(&stdout).expect("one object")
    };
    let across = judge(&["--labels", "label", "--cross-validate"]);
    for key in ["balanced_accuracy", "specificity", "sensitivity", "auc"] {
        assert_eq!(across[key], 1.0, "{across}");
    }
    assert_eq!((&across["n"], &across["objects"]), (&8.into(), &4.into()));
    let trained = judge(&["--labels", "label", "--train", &file, "--save", &model]);
    assert_eq!(judge(&["--labels", "label", "--model", &model]), trained);
    let check = |line: &[&str], part: &str| {
        let (code, _, stderr) = run(&[&["eval", "recording"], line].concat());
        assert_ne!(code, 0, "{line:?}");
        assert!(stderr.contains(part), "{line:?}: {stderr}");
    };
    check(&[&file], "--labels");
    check(&[&file, "--labels", "truth"], "--labels-file");
    check(&["no/such.csv", "--labels", "label"], "no/such.csv");
    check(&[&model, "--labels", "label"], "could not");
}

/// A dome that speaks in counts, turned and mixed, as `atas-sensor --dry-run` prints it; `force_n` by frame of 10 ms.
fn dry_run(frames: usize, force_n: impl Fn(usize) -> [f64; 3]) -> String {
    let mut text =
        "byte_offset,count,status,fx_counts,fy_counts,fz_counts,arrival,captured_ns\n".to_owned();
    for frame in 0..frames {
        let [n, a, b] = force_n(frame);
        let flicker = |axis: usize| ((frame * 7919 + axis * 104_729) % 101) as f64 / 50.0 - 1.0;
        text += &format!(
            "{},{frame},0,{:.2},{:.2},{:.2},next,{}\n",
            16 * frame,
            50.0 + 25.0 * a + 2.0 * n + flicker(0),
            -9.0 - 24.0 * b + 1.5 * a + flicker(1),
            4.0 - 60.0 * n + 3.0 * b + flicker(2),
            1_000_000_000 + 10_000_000 * frame
        );
    }
    text
}

#[test]
fn a_fingertip_is_calibrated_from_guided_presses() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = |name: &str| folder.path().join(name).display().to_string();
    // Guided: as many steps as loads, each as long as asked for, in order.
    let mut guided = atas(&[
        "calibrate",
        "guide",
        "--normal",
        "1,2,4",
        "--tangential",
        "1,-1",
        "--seconds",
        "0.01",
    ])
    .args(["--out", &path("guided.csv")])
    .stdin(Stdio::piped())
    .stderr(Stdio::null())
    .spawn()
    .expect("it starts");
    let mut entered = guided.stdin.take().expect("piped");
    std::io::Write::write_all(&mut entered, &[b'\n'; 8]).expect("entered");
    assert!(guided.wait().expect("it ends").success());
    let steps = std::fs::read_to_string(path("guided.csv")).expect("steps");
    let rows: Vec<Vec<f64>> = steps
        .lines()
        .skip(1)
        .map(|line| {
            line.split(',')
                .map(|cell| cell.parse().expect("a number"))
                .collect()
        })
        .collect();
    assert_eq!(rows.len(), 8, "{steps}");
    assert!(
        rows.iter().all(|row| row[1] >= row[0] + 1e7) && rows.is_sorted_by_key(|row| row[0] as u64)
    );
    assert_eq!(rows[4][2..], [2.0, 1.0, 0.0], "{steps}");
    // The same with loads on a clock of our own: eleven steps of a second each.
    let load = |step: usize| match step {
        0 => [0.0; 3],
        1..=4 => [step as f64, 0.0, 0.0],
        5..=7 => [2.0, step as f64 - 6.0, 0.0],
        _ => [2.0, 0.0, step as f64 - 9.0],
    };
    let mut table = "from_ns,to_ns,normal_n,tangential1_n,tangential2_n\n".to_owned();
    for step in 0..11 {
        let [n, a, b] = load(step);
        let from_ns = 1_000_000_000 + 1_000_000_000 * step;
        table += &format!("{from_ns},{},{n},{a},{b}\n", from_ns + 990_000_000);
    }
    let write = |name: &str, text: &str| std::fs::write(path(name), text).expect("written");
    write("steps.csv", &table);
    write("presses.csv", &dry_run(1100, |frame| load(frame / 100)));
    let warming = |text: &str, kelvin: f64| -> String {
        let warm = |(row, line): (usize, &str)| match row {
            0 => format!("{line},temperature_c\n"),
            _ => format!("{line},{}\n", 20.0 + kelvin * row as f64 / 1500.0),
        };
        text.lines().enumerate().map(warm).collect()
    };
    write("quiet.csv", &warming(&dry_run(1500, |_| [0.0; 3]), 3.0));
    let drifts = dry_run(1500, |frame| [0.4 * frame as f64 / 1500.0, 0.0, 0.0]);
    write("drifts.csv", &warming(&drifts, 3.0));
    write("barely.csv", &warming(&dry_run(1500, |_| [0.0; 3]), 0.3));
    let mut block = "closing_m,normal_n\n".to_owned();
    for i in 1..200 {
        let force_n = 0.02 * f64::from(i);
        block += &format!("{},{force_n}\n", 0.03 + 2.0 * 0.0005 * force_n.powf(0.5));
    }
    write("block.csv", &block);
    let arguments: Vec<String> = [
        ("--presses", "presses.csv"),
        ("--reference", "steps.csv"),
        ("--silence", "quiet.csv"),
        ("--block", "block.csv"),
        ("--out", "tip.toml"),
        ("--daemon", "daemon.toml"),
        ("--figure", "tip.svg"),
    ]
    .iter()
    .flat_map(|(option, name)| [(*option).to_owned(), path(name)])
    .collect();
    let line: Vec<&str> = ["calibrate", "fit", "--format", "json", "--hand", "left"]
        .into_iter()
        .chain(arguments.iter().map(String::as_str))
        .collect();
    let (code, stdout, stderr) = run(&line);
    assert_eq!(code, 0, "{stderr}");
    let report: serde_json::Value = serde_json::from_str(&stdout).expect("one object");
    let number = |value: &serde_json::Value| value.as_f64().expect("a number");
    assert_eq!(report["presses"], 10, "{report}");
    for axis in 0..3 {
        assert!(number(&report["error_n"][axis]) < 0.08, "{report}");
    }
    let on_n = number(&report["thresholds"]["touch_on_n"]);
    assert!((0.03..0.3).contains(&on_n), "{report}");
    assert!(
        (number(&report["block"]["tip_compression_m"]) - 0.0005).abs() < 1e-5,
        "{report}"
    );
    let drift = &report["drift"];
    assert!(number(&drift["element_n_min"][0]) < 0.05, "{report}");
    assert!(
        (number(&drift["warmth"]["span_k"]) - 3.0).abs() < 0.01,
        "{report}"
    );
    assert!(
        number(&drift["warmth"]["total_n_k"][0]).abs() < 0.005,
        "{report}"
    );
    let saved = std::fs::read_to_string(path("tip.toml")).expect("a calibration");
    assert!(saved.contains("[drift.warmth]"), "{saved}");
    let warned = |silence: &str, parts: &[&str]| {
        let (silence, out) = (path(silence), path(&format!("{silence}.toml")));
        let presses = [path("presses.csv"), path("steps.csv")];
        let given = [
            "--presses",
            &presses[0],
            "--reference",
            &presses[1],
            "--silence",
            &silence,
        ];
        let (code, stdout, stderr) =
            run(&[&["calibrate", "fit", "--out", &out], &given[..]].concat());
        assert_eq!(code, 0, "{stderr}");
        for part in parts {
            assert!(stdout.contains(part), "{part}: {stdout}");
        }
    };
    warned(
        "drifts.csv",
        &[
            "element 0 drifts most: 1.",
            "a kelvin moves the total force by 0.1",
            "beware: 1 of 1 elements move by more than",
            "beware: a kelvin moves the force by 0.1",
        ],
    );
    warned(
        "barely.csv",
        &["beware: the temperature moved by less than 0.5 K"],
    );
    let daemon = std::fs::read_to_string(path("daemon.toml")).expect("a configuration");
    let told: toml::Table = daemon.parse().expect("TOML");
    // Ten milliseconds from frame to frame: what the daemon must know of a sensor that is no faster.
    let rate_hz = told["hands"]["left"]["rate_hz"].as_float();
    let hold_age_s = told["intake"]["hold_age_s"].as_float();
    assert_eq!(
        (rate_hz, hold_age_s),
        (Some(100.0), Some(0.035)),
        "{daemon}"
    );
    let told = told["perception"].as_table().expect("a table");
    let told_on_n = told["touch_on_n"].as_float().expect("a number");
    assert!((told_on_n - on_n).abs() < 1e-9, "{daemon}");
    assert!(
        told["tip_exponent"]
            .as_float()
            .is_some_and(|p| (p - 0.5).abs() < 0.02),
        "{daemon}"
    );
    let figure = std::fs::read_to_string(path("tip.svg")).expect("a figure");
    assert!(figure.starts_with("<svg") && figure.matches("<circle").count() > 1000);
    // Nothing is overwritten, and what is missing is named.
    let (code, _, stderr) = run(&line);
    assert!(code == 1 && stderr.contains("tip.toml"), "{stderr}");
    let fit = ["calibrate", "fit", "--out", "other.toml", "--presses"];
    let check = |presses: &str, more: &[&str], part: &str| {
        let line = [&fit[..], &[presses], more].concat();
        let (code, _, stderr) = run(&line);
        assert!(code == 1 && stderr.contains(part), "{stderr}");
    };
    check(&path("steps.csv"), &[], "--dry-run");
    check(&path("presses.csv"), &[], "no column normal_n");
    check(&path("presses.csv"), &["--layout", "dome"], "dome-41");
}
