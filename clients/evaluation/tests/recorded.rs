//! Evaluation of recordings: synthetic ones with exact truth, and real ones if they are installed
//! beside the source tree.
#![expect(clippy::print_stdout, reason = "reports skipped tests")]

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use atas_evaluation::recorded::{Fit, Labels, Model, Sheet, Verdict, evaluate, train};

fn noise(index: usize) -> f64 {
    let mut z = (index as u64 + 1).wrapping_mul(0x9E37_79B9_7F4A_7C15);
    z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    (z ^ (z >> 31)) as f64 / u64::MAX as f64 * 2.0 - 1.0
}

fn sheet(text: &str) -> Sheet {
    Sheet::read(Path::new("made.csv"), text.as_bytes()).expect("a table")
}

fn labelled(column: &str) -> Labels {
    Labels {
        column: Some(column.to_owned()),
        ..Labels::default()
    }
}

/// Synthetic recording of 24 electrodes: three objects with four stable contacts and four slips
/// each.
fn slips(rate_hz: usize, mut cell: impl FnMut(usize, usize, String) -> String) -> String {
    let mut text = "label,sequence,object,t_s".to_owned();
    (1..=24).for_each(|e| write!(text, ",ff_e{e}").expect("a string"));
    text.push('\n');
    for sequence in 0..24 {
        let (object, slips) = (sequence % 3, sequence / 3 % 2 == 1);
        let label = if slips {
            ["n", "aw", "e", "s"][sequence / 6]
        } else {
            "t"
        };
        for frame in 0..5 * rate_hz / 2 {
            let at_s = frame as f64 / rate_hz as f64;
            write!(text, "{label},{label}_{sequence},o{object},{at_s}").expect("a string");
            for electrode in 0..24 {
                let speed = if slips {
                    40.0 + 10.0 * object as f64
                } else {
                    1.0
                };
                let moved = speed * at_s * (1.0 + (electrode % 5) as f64 * 0.3);
                let flicker = 6.0 * noise((sequence * 1000 + frame) * 24 + electrode);
                let counts = format!("{:.0}", 3300.0 + moved + flicker);
                write!(text, ",{}", cell(frame, electrode, counts)).expect("a string");
            }
            text.push('\n');
        }
    }
    text
}

#[test]
fn slip_is_detected_at_any_rate_and_with_gaps() {
    let shipped = Model::built_in().expect("a model");
    let check = |name: &str, text: &str| {
        for fit in [Fit::Given, Fit::Across] {
            let verdict = evaluate(&sheet(text), &labelled("label"), &shipped, fit).expect(name);
            let rates = verdict.rates.expect("two classes");
            assert_eq!(
                (verdict.n, verdict.objects, rates.auc),
                (24, 3, 1.0),
                "{name} {fit:?}: {verdict:?}"
            );
            assert_eq!(rates.balanced_accuracy, 1.0, "{name} {fit:?}: {verdict:?}");
        }
    };
    check("100 Hz", &slips(100, |_, _, counts| counts));
    check("30 Hz", &slips(30, |_, _, counts| counts));
    check("400 Hz", &slips(400, |_, _, counts| counts));
    let holes = |frame: usize, electrode: usize, counts: String| match (frame % 17, electrode) {
        (3, 5) => "NaN".to_owned(),
        (4, 6) => String::new(),
        (5, _) => "inf".to_owned(),
        (_, 7) => "broken".to_owned(),
        _ => counts,
    };
    check("holes", &slips(100, holes));
    // No time column, half of the electrodes, other label texts.
    let fewer = slips(100, |_, _, counts| counts)
        .lines()
        .map(|line| {
            let cells: Vec<&str> = line.split(',').collect();
            [&cells[..3], &cells[4..16]].concat().join(",") + "\n"
        })
        .collect::<String>();
    check("fewer columns", &fewer);
    let plain = slips(100, |_, _, counts| counts)
        .lines()
        .map(|line| {
            let (label, rest) = line.split_once(',').expect("cells");
            let plain = match label {
                "label" => "label",
                "t" => "0",
                _ => "1",
            };
            format!("{plain},{rest}\n")
        })
        .collect::<String>();
    check("0 and 1", &plain);
}

/// A recording faster than the sensor repeats readings; only new readings count for the noise.
#[test]
fn repeated_readings_are_ignored() {
    let text = slips(100, |_, _, counts| counts);
    let mut lines = text.lines();
    let mut held = format!("{}\n", lines.next().expect("a header"));
    for line in lines {
        let cells: Vec<&str> = line.splitn(5, ',').collect();
        let at_s: f64 = cells[3].parse().expect("a time");
        for repeat in 0..4 {
            let at_s = at_s + 0.0025 * f64::from(repeat);
            let row = format!("{},{at_s},{}", cells[..3].join(","), cells[4]);
            writeln!(held, "{row}").expect("a string");
        }
    }
    let shipped = Model::built_in().expect("a model");
    let of = |text: &str| {
        let verdict = evaluate(&sheet(text), &labelled("label"), &shipped, Fit::Given);
        verdict.expect("judged").rates.expect("two classes")
    };
    assert_eq!(of(&held), of(&text));
}

#[test]
fn ignored_data_and_assumptions_give_warnings() {
    let shipped = Model::built_in().expect("a model");
    let output = |text: &str, parts: &[&str]| {
        let verdict = evaluate(&sheet(text), &labelled("label"), &shipped, Fit::Given);
        let verdict = verdict.expect("judged");
        let output = verdict.warnings.join("; ");
        for part in parts {
            assert!(output.contains(part), "{part}: {output}");
        }
        assert_eq!(verdict.warnings.len(), parts.len(), "{output}");
        assert_eq!(verdict.rates.expect("two classes").auc, 1.0);
    };
    let text = slips(100, |_, _, counts| counts);
    output(&text, &[]);
    output(
        &text.replacen(",t_s", ",when", 1),
        &["100 frames per second"],
    );
    let damaged = slips(100, |frame, electrode, counts| match electrode {
        2 => "off".to_owned(),
        3 => "7".to_owned(),
        4 if frame % 10 == 0 => "NaN".to_owned(),
        _ => counts,
    });
    output(
        &damaged,
        &[
            "no numbers in ff_e3",
            "constant values in ff_e4",
            "600 readings (0.4 %)",
        ],
    );
    // Labels per frame instead of a case-number column; some are missing.
    let frames = text.replacen(",sequence,", ",row,", 1);
    output(&frames, &[]);
}

#[test]
fn verdict_is_deterministic() {
    let text = slips(100, |_, _, counts| counts);
    let model = Model::built_in().expect("a model");
    let once = || {
        let verdict = evaluate(&sheet(&text), &labelled("label"), &model, Fit::Across);
        serde_json::to_string(&verdict.expect("a verdict")).expect("JSON")
    };
    assert_eq!(once(), once());
}

/// Synthetic presses of fruit that ruptures at 3 to 8 N.
fn presses() -> (String, String) {
    let mut text = "fruit,trial,force_N,pos_mm,t_s\n".to_owned();
    let mut truths = "fruit,trial,rupture_N\n".to_owned();
    for trial in 0..12 {
        let rupture_n = 3.0 + 0.45 * f64::from(trial);
        writeln!(truths, "plum,p{trial},{rupture_n}").expect("a string");
        let mut position_mm = 35.0;
        for frame in 0..1000 {
            let force_n = 0.2 + 0.01 * f64::from(frame);
            position_mm += 0.01 * if force_n < rupture_n { 0.5 } else { 5.0 };
            let at_s = 0.01 * f64::from(frame);
            writeln!(text, "plum,p{trial},{force_n},{position_mm},{at_s}").expect("a string");
        }
    }
    (text, truths)
}

#[test]
fn rupture_uses_labels_of_a_neighbouring_file() {
    let folder = tempfile::tempdir().expect("a folder");
    let (text, truths) = presses();
    let write = |name: &str, text: &str| {
        let path = folder.path().join(name);
        std::fs::write(&path, text).expect("written");
        path
    };
    let (recording, _) = (write("traces.csv", &text), write("trials.csv", &truths));
    let sheet = Sheet::open(&recording).expect("a table");
    let shipped = Model::built_in().expect("a model");
    let labels = labelled("rupture_N");
    // Unknown fruit: the force at yielding is the prediction.
    let unknown = evaluate(&sheet, &labels, &shipped, Fit::Given).expect("judged");
    assert!(unknown.mae_n.expect("an error") < 0.5, "{unknown:?}");
    let across = evaluate(&sheet, &labels, &shipped, Fit::Across).expect("judged");
    let plums = across.sorts["plum"];
    assert!(plums.n == 12 && plums.mae_n < 0.03, "{plums:?}");
    assert!((0.0..0.6).contains(&plums.beyond_n), "{plums:?}");
    assert!(plums.mae_of_mean_n > 1.0, "{plums:?}");
    // The fitted model survives saving and reading, with the same results.
    let trained = train(&sheet, &labels, &shipped).expect("fitted");
    let saved = folder.path().join("mine.toml");
    trained.save(&saved).expect("saved");
    assert_eq!(Model::open(&saved).expect("read"), trained);
    assert!(trained.save(&saved).is_err(), "a model overwrote a file");
    let known = evaluate(&sheet, &labels, &trained, Fit::Given).expect("judged");
    assert!(known.mae_n.expect("an error") < 0.03, "{known:?}");
}

/// Synthetic squeezes by two fingers: stiff and soft objects, in N per degree.
fn squeezes() -> String {
    let mut text =
        "sample,label,step,f1_x,f1_y,f1_z,f2_x,f2_y,f2_z,pos1_deg,pos2_deg,t_s\n".to_owned();
    for sample in 0..12 {
        let (label, stiffness) = if sample % 2 == 0 {
            (3, 0.5)
        } else {
            (13, 0.05)
        };
        for step in 0..50 {
            let angle_deg = 20.0 + 0.7 * f64::from(step);
            let pressed = (angle_deg - 32.0 - 0.3 * f64::from(sample)).max(0.0) * stiffness;
            let flicker =
                |axis: usize| 0.004 * noise((sample as usize * 50 + step as usize) * 6 + axis);
            writeln!(
                text,
                "{sample},{label}.0,{step},{},{},{},{},{},{},{angle_deg},{angle_deg},{}",
                0.2 + flicker(0),
                flicker(1),
                pressed + flicker(2),
                flicker(3),
                pressed * 0.6 + flicker(4),
                pressed * 0.8 + flicker(5),
                0.26 * f64::from(step)
            )
            .expect("a string");
        }
    }
    text
}

#[test]
fn hard_and_soft_are_classified() {
    let text = squeezes();
    let labels = Labels {
        objects: Some("label".to_owned()),
        ..labelled("label")
    };
    let shipped = Model::built_in().expect("a model");
    let verdict = evaluate(&sheet(&text), &labels, &shipped, Fit::Given).expect("judged");
    assert_eq!((verdict.n, verdict.objects), (12, 2));
    assert_eq!(verdict.rates.expect("two classes").auc, 1.0);
    assert_eq!(verdict.first_step.expect("two classes").auc, 1.0);
    let trained = train(&sheet(&text), &labels, &shipped).expect("fitted");
    let verdict = evaluate(&sheet(&text), &labels, &trained, Fit::Given).expect("judged");
    assert_eq!(verdict.rates.expect("two classes").balanced_accuracy, 1.0);
}

#[test]
fn contacts_are_counted_and_evaluated_per_frame() {
    let mut text = "fx_counts,fy_counts,fz_counts,touch\n".to_owned();
    for frame in 0..5000 {
        let touched = frame / 500 % 2 == 1;
        // Flicker below the threshold between contacts is not a contact.
        let fz = if touched {
            -100 - (frame % 7)
        } else {
            -10 - 12 * (frame % 2)
        };
        writeln!(
            text,
            "{},{},{fz},{}",
            frame % 3,
            frame % 5,
            u8::from(touched)
        )
        .expect("a string");
    }
    let shipped = Model::built_in().expect("a model");
    let verdict =
        evaluate(&sheet(&text), &labelled("touch"), &shipped, Fit::Given).expect("judged");
    assert_eq!(verdict.touches.expect("touches").len(), 5);
    // The low-pass delays every beginning and end by a few frames.
    assert!(verdict.rates.expect("two classes").balanced_accuracy > 0.98);
    let bare = evaluate(&sheet(&text), &Labels::default(), &shipped, Fit::Given).expect("judged");
    assert_eq!((bare.n, bare.touches.expect("touches").len()), (5000, 5));
}

#[test]
fn unusable_recordings_are_rejected_with_advice() {
    let shipped = Model::built_in().expect("a model");
    let check = |text: &str, labels: &Labels, fit: Fit, part: &str| {
        let error = evaluate(&sheet(text), labels, &shipped, fit).expect_err(part);
        assert!(format!("{error:#}").contains(part), "{error:#}");
    };
    let label = labelled("label");
    check(
        "a,b\n1,2\n",
        &label,
        Fit::Given,
        "no kind of recording has its columns (a, b)",
    );
    check(
        "ff_e1,sequence\n1,2\n",
        &Labels::default(),
        Fit::Given,
        "--labels",
    );
    check("ff_e1,sequence\n1,2\n", &label, Fit::Given, "--labels-file");
    check(
        "force_N,pos_mm,label\n1,2,soft\n",
        &label,
        Fit::Given,
        "no case has a usable label",
    );
    let one_object = "ff_e1,sequence,object,label\n1,1,cup,t\n2,2,cup,t\n3,3,cup,n\n";
    check(one_object, &label, Fit::Across, "leaving out \"cup\"");
    assert!(Sheet::read(Path::new("empty.csv"), &b"a,b\n"[..]).is_err());
    // A verdict without evaluated cases is an error.
    let text = slips(100, |_, _, counts| counts);
    let given = |text: &str, labels: &Labels, part: &str| check(text, labels, Fit::Given, part);
    let lines = |keep: fn(&&str) -> bool| text.lines().filter(keep).collect::<Vec<_>>().join("\n");
    let one_class = lines(|line| line.starts_with("label") || line.starts_with("t,"));
    given(&one_class, &label, "all 12 usable labels mean stable");
    let still = slips(100, |_, _, _| "7".to_owned());
    given(
        &still,
        &label,
        "is constant (ff_e1, ff_e2, ff_e3 and 21 more)",
    );
    let commas = slips(100, |_, _, _| "\"3,5\"".to_owned());
    given(&commas, &label, "check that the decimal sign is a point");
    let short =
        text.replace("_", "_x")
            .lines()
            .enumerate()
            .fold(String::new(), |text, (row, line)| {
                let end = if row == 0 {
                    line.to_owned()
                } else {
                    line.replacen("_x", &format!("_{row}x"), 1)
                };
                text + &end + "\n"
            });
    given(
        &short.replace("ff_x", "ff_"),
        &label,
        "two windows of 0.15 s",
    );
    let both = text.replacen("\nt,t_0,", "\nn,t_0,", 1);
    given(&both, &label, "have the labels \"n\" and \"t\"");
    let mut soft =
        "sample,label,step,f1_x,f1_y,f1_z,f2_x,f2_y,f2_z,pos1_deg,pos2_deg,t_s\n".to_owned();
    for line in squeezes().lines().skip(1) {
        let cells: Vec<&str> = line.split(',').collect();
        let weak = |cell: &str| {
            cell.parse::<f64>()
                .map(|n| (n * 1e-3).to_string())
                .expect("a number")
        };
        let forces: Vec<String> = cells[3..9].iter().map(|cell| weak(cell)).collect();
        writeln!(
            soft,
            "{},{},{}",
            cells[..3].join(","),
            forces.join(","),
            cells[9..].join(",")
        )
        .expect("a string");
    }
    given(&soft, &label, "check that the forces are in newtons");
    let model = tempfile::NamedTempFile::new().expect("a file");
    std::fs::write(model.path(), "format = 2\n").expect("written");
    assert!(Model::open(model.path()).is_err());
}

/// Real recordings are third-party data outside the repository.
fn real(name: &str) -> Option<PathBuf> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../../../shared/data")
        .join(name);
    if !path.exists() {
        println!("skipped: {} does not exist", path.display());
    }
    path.exists().then_some(path)
}

fn judged(name: &str, labels: Labels, fit: Fit) -> Option<Verdict> {
    let sheet = Sheet::open(&real(name)?).expect("a table");
    Some(evaluate(&sheet, &labels, &Model::built_in().expect("a model"), fit).expect(name))
}

#[test]
fn real_slip_rates_hold_on_unseen_objects() {
    for fit in [Fit::Given, Fit::Across] {
        let Some(verdict) = judged("biotacsp_dos_basic/basic.csv", labelled("label"), fit) else {
            return;
        };
        let rates = verdict.rates.expect("two classes");
        assert_eq!((verdict.n, verdict.objects, verdict.skipped), (111, 4, 0));
        assert!(rates.specificity >= 0.96, "{fit:?}: {rates:?}");
        assert!(rates.balanced_accuracy >= 0.95, "{fit:?}: {rates:?}");
    }
}

#[test]
fn real_squeezes_are_classified_at_first_step() {
    let Some(verdict) = judged("grasp20_even/grasps.csv", labelled("label"), Fit::Across) else {
        return;
    };
    let auc = |rates: Option<atas_evaluation::recorded::Rates>| rates.expect("two classes").auc;
    assert_eq!((verdict.n, verdict.objects), (26, 7));
    assert!(auc(verdict.rates) >= 0.99, "{verdict:?}");
    assert!(auc(verdict.first_step) >= 0.90, "{verdict:?}");
}

#[test]
fn real_fruit_rupture_error_is_bounded() {
    let labels = || labelled("rupture_N");
    let Some(verdict) = judged("fruit_training/traces.csv", labels(), Fit::Across) else {
        return;
    };
    assert!(verdict.sorts["kiwi"].mae_n < 0.455, "{verdict:?}");
    assert!(verdict.sorts["mango"].mae_n < 1.035, "{verdict:?}");
}

#[test]
fn five_real_contacts_are_counted_with_any_stamps() {
    let Some(path) = real("optoforce_wire/capture.bin") else {
        return;
    };
    let bytes = std::fs::read(path).expect("a capture");
    // 7-byte acknowledgement, then 16-byte frames without gaps. Frames read at once have
    // meaningless time stamps.
    for stamp_ns in [1_000_000, 650] {
        let mut text = "fx_counts,fy_counts,fz_counts,captured_ns\n".to_owned();
        for (index, frame) in bytes[7..].chunks_exact(16).enumerate().take(34_374) {
            let count = |at: usize| i16::from_be_bytes([frame[at], frame[at + 1]]);
            let at_ns = 5_000_000_000 + index * stamp_ns;
            writeln!(text, "{},{},{},{at_ns}", count(8), count(10), count(12)).expect("a string");
        }
        let shipped = Model::built_in().expect("a model");
        let verdict =
            evaluate(&sheet(&text), &Labels::default(), &shipped, Fit::Given).expect("judged");
        let begins = verdict.touches.expect("touches");
        assert_eq!(begins.len(), 5, "{begins:?}");
        for (begin, expected) in begins.iter().zip([12_803, 24_320, 25_442, 26_757, 28_327]) {
            // The filter settles about one frame earlier without valid time stamps.
            assert!((expected - 1..expected + 20).contains(begin), "{begins:?}");
        }
    }
}
