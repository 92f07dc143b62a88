//! `atas calibrate` from recorded presses to its output files.

use std::process::Stdio;

use crate::{atas, run};

/// Makes a table of `atas-sensor --dry-run`: one element in counts with rotated and coupled axes;
/// `force_n` per frame of 10 ms.
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
    // Guided session: one step per load, in order, each of the requested duration.
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
    // Session with a synthetic clock: eleven steps of 1 s.
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
            "largest drift: element 0, 1.",
            "1 K changes the total force by 0.1",
            "warning: 1 of 1 elements drift by more than",
            "warning: a temperature change of 1 K changes the force by 0.1",
        ],
    );
    warned(
        "barely.csv",
        &["warning: the temperature changed by less than 0.5 K"],
    );
    let daemon = std::fs::read_to_string(path("daemon.toml")).expect("a configuration");
    let output: toml::Table = daemon.parse().expect("TOML");
    // A frame interval of 10 ms needs a longer frame age limit.
    let rate_hz = output["hands"]["left"]["rate_hz"].as_float();
    let hold_age_s = output["intake"]["hold_age_s"].as_float();
    assert_eq!(
        (rate_hz, hold_age_s),
        (Some(100.0), Some(0.035)),
        "{daemon}"
    );
    let output = output["perception"].as_table().expect("a table");
    let told_on_n = output["touch_on_n"].as_float().expect("a number");
    assert!((told_on_n - on_n).abs() < 1e-9, "{daemon}");
    assert!(
        output["tip_exponent"]
            .as_float()
            .is_some_and(|p| (p - 0.5).abs() < 0.02),
        "{daemon}"
    );
    let figure = std::fs::read_to_string(path("tip.svg")).expect("a figure");
    assert!(figure.starts_with("<svg") && figure.matches("<circle").count() > 1000);
    // Existing files are not overwritten; errors name the missing input.
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
