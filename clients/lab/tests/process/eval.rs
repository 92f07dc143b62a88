//! Output and errors of `atas eval`.

use crate::run;

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
fn merged_parts_equal_a_single_run() {
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
    let refused = |parts: &[&str], message: &str| {
        let (code, _, stderr) = merge(parts);
        assert_eq!(code, 1, "{parts:?}");
        assert!(stderr.contains(message), "{stderr}");
    };
    refused(&[&one], "part 2/2 is missing");
    refused(&[&one, &one], "part 1/2 is given twice");
    assert_eq!(eval(&["--shard", "2/2", "--out", &two]).0, 0);
    // A part with a truncated last trial continues with that trial.
    let bytes = std::fs::read(&two).expect("readable");
    std::fs::write(&two, &bytes[..bytes.len() - 9]).expect("writable");
    refused(&[&one, &two], "2.part: it is damaged after its trial 3");
    let goes_on = |ran: u64| {
        let damaged = std::fs::read(&two).expect("readable");
        let (code, again, message) = eval(&["--shard", "2/2", "--out", &two]);
        let again: serde_json::Value = serde_json::from_str(&again).expect("JSON");
        assert_eq!((code, &again["ran"]), (0, &ran.into()), "{message}");
        assert!(
            message.contains("2.part is damaged after its trial"),
            "{message}"
        );
        let kept = std::fs::read(format!("{two}.damaged")).expect("kept");
        assert!(kept == damaged, "the damaged file is kept unchanged");
    };
    goes_on(1);
    // A flipped bit is detected, and its trial runs again.
    let mut flipped = std::fs::read(&two).expect("readable");
    *flipped.last_mut().expect("a trial") ^= 1;
    std::fs::write(&two, flipped).expect("writable");
    refused(&[&one, &two], "(its checksum is wrong)");
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
fn fitted_calibration_is_compared_with_exact_one() {
    let eval = |threads: &str| {
        let words = "eval calibration --trials 2 --first-seed 1 --format json --threads";
        let words: Vec<&str> = words.split(' ').chain([threads]).collect();
        let (code, stdout, stderr) = run(&words);
        assert_eq!(code, 0, "{stderr}");
        stdout
    };
    let output = eval("1");
    assert_eq!(output, eval("2"), "independent of the number of threads");
    let report: serde_json::Value = serde_json::from_str(&output).expect("one object");
    assert_eq!(
        (&report["trials"], &report["purpose"]),
        (&2.into(), &"tuning".into())
    );
    for under in ["exact", "fitted"] {
        assert_eq!(report[under]["successes"], 2, "{under}: {report}");
    }
    assert_eq!(report["fit"]["fingertips"], 4, "{report}");
    for axis in 0..3 {
        let share = report["fit"]["error_share_most"][axis].as_f64();
        assert!(
            share.is_some_and(|share| share > 0.0 && share < 0.3),
            "{report}"
        );
    }
}

/// Makes a table of a fingertip with four electrodes: stable contacts and slips of one object.
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
fn recording_evaluation_prints_json_and_reports_errors() {
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
