//! Fits to synthetic recordings with known effects, and to public recordings.

use std::path::{Path, PathBuf};

use sim_backend::random::Random;

use super::response::{Effects, model_n};
use super::*;

const PERIOD_S: f64 = 0.02;

fn arguments(recording: &Path, reading: &[&str]) -> CalibrateModel {
    CalibrateModel {
        check_domain: false,
        recording: recording.to_owned(),
        reading: reading.iter().map(|name| (*name).to_owned()).collect(),
        force: None,
        force_unit: 1.0,
        newtons_per_unit: 1.0,
        group: None,
        rate_hz: 100.0,
        accuracy: None,
        out: None,
    }
}

/// Presses of different peaks with holds, 200 s: forces per row, N.
fn presses() -> Series {
    let peaks = [8.0, 3.0, 6.0, 1.5, 7.0, 8.0, 2.0, 5.0, 6.5, 8.0];
    let force_n = |time_s: f64| {
        let peak_n = peaks[(time_s / 20.0) as usize % peaks.len()];
        let phase_s = time_s % 20.0;
        let ramp = (phase_s / 3.0).min((15.0 - phase_s) / 3.0).clamp(0.0, 1.0);
        peak_n * ramp
    };
    let time_s: Vec<f64> = (0..10_000).map(|row| f64::from(row) * PERIOD_S).collect();
    Series {
        force_n: time_s.iter().map(|time_s| force_n(*time_s)).collect(),
        groups: vec![0],
        has_times: true,
        readings: Vec::new(),
        time_s,
    }
}

/// Recording of a sensor with these effects, 250 counts per newton.
fn recording(effects: Effects, noise_n: f64, drift_n_s: f64) -> Series {
    let mut series = presses();
    let mut random = Random::new(11, 1);
    let model_n = model_n(&series, &effects, 8.0);
    let counts = series.time_s.iter().zip(&model_n).map(|(time_s, n)| {
        let reading_n = n + drift_n_s * time_s + noise_n * random.gaussian();
        vec![(250.0 * reading_n).round() + 17.0]
    });
    series.readings = counts.collect();
    series
}

fn fitted(series: &Series) -> Report {
    fit(series, &arguments(Path::new("synthetic.csv"), &["counts"])).expect("a fit")
}

#[test]
fn fit_recovers_known_effects() {
    for (effects, noise_n) in [
        (
            Effects {
                latency_s: 0.06,
                hysteresis: 0.05,
                creep_per_decade: 0.05,
            },
            0.01,
        ),
        (
            Effects {
                latency_s: 0.0,
                hysteresis: 0.08,
                creep_per_decade: 0.0,
            },
            0.02,
        ),
        (
            Effects {
                latency_s: 0.1,
                hysteresis: 0.0,
                creep_per_decade: 0.03,
            },
            0.005,
        ),
    ] {
        let report = fitted(&recording(effects, noise_n, 0.0));
        let model = &report.model;
        let near = |found: f64, truth: f64, tolerance: f64, what: &str| {
            assert!(
                (found - truth).abs() <= tolerance,
                "{what}: {found}, {truth}; {report:?}"
            );
        };
        near(model.frames.latency_s, effects.latency_s, 0.01, "latency");
        near(
            model.hysteresis.map_or(0.0, |of| of.share),
            effects.hysteresis,
            0.005,
            "hysteresis",
        );
        near(
            model.creep.map_or(0.0, |of| of.per_decade),
            effects.creep_per_decade,
            0.005,
            "creep",
        );
        near(model.noise_n[0] / noise_n, 1.0, 0.35, "noise");
        near(model.step_n[0], 0.004, 1e-4, "step");
        let residual_n = report.residual_n.expect("a reference");
        near(residual_n / noise_n, 1.0, 0.25, "held-out residual");
        assert!(
            model.saturation_n.is_none() && model.drift.is_none(),
            "{report:?}"
        );
    }
}

#[test]
fn fit_recovers_drift_and_reports_missing_effects() {
    let report = fitted(&recording(Effects::default(), 0.01, 0.002));
    let drift = report.model.drift.expect("a drift");
    assert!((drift.rate_n_s[0] / 0.002 - 1.0).abs() < 0.1, "{report:?}");
    assert!(
        report.model.hysteresis.is_none() && report.model.creep.is_none(),
        "{report:?}"
    );
    let reasons = report.not_identified.join("; ");
    for name in [
        "hysteresis: ",
        "creep per decade: ",
        "saturation: ",
        "gain spread",
    ] {
        assert!(reasons.contains(name), "{reasons}");
    }
}

#[test]
fn fitted_model_file_is_readable() {
    let effects = Effects {
        latency_s: 0.05,
        hysteresis: 0.05,
        creep_per_decade: 0.05,
    };
    let report = fitted(&recording(effects, 0.01, 0.001));
    let text = model_file(&report).expect("text");
    assert_eq!(
        SensorModel::parse(&text, "fitted.toml").expect(&text),
        report.model
    );
}

/// Requirement: the fitted model is at least as accurate as the sensor's stated accuracy on the
/// half of the recording that was not used for the fit.
#[test]
fn eflesh_model_is_within_stated_accuracy() {
    const STATED_N: f64 = 0.27;
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/eflesh/normal-force.csv");
    let names: Vec<String> = (1..=5)
        .flat_map(|board| ["x", "y", "z"].map(|axis| format!("b{board}_{axis}_ut")))
        .collect();
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    let arguments = CalibrateModel {
        force: Some("force_g".to_owned()),
        force_unit: 9.806_65e-3,
        ..arguments(&path, &names)
    };
    let report = report(&arguments).expect("a fit");
    let residual_n = report.residual_n.expect("a reference");
    assert!(residual_n <= STATED_N, "{residual_n} N: {report:?}");
    // The skin creeps; with creep, hysteresis explains nothing more.
    let creep = report.model.creep.expect("creep").per_decade;
    assert!((0.03..0.12).contains(&creep), "{report:?}");
}

/// Recordings of developers, which are not part of the project.
fn shared(file: &str) -> Option<PathBuf> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../../../shared/data")
        .join(file);
    let is_there = path.is_file();
    if !is_there {
        #[expect(clippy::print_stderr, reason = "an absent recording must be visible")]
        {
            eprintln!("not tested: {} is absent", path.display());
        }
    }
    is_there.then_some(path)
}

#[test]
fn recordings_without_force_determine_noise_and_step() {
    let checks = [
        (
            "optoforce_wire/frames_expected.csv",
            vec!["fz_counts"],
            None,
            2000.0 / 6049.0,
            0.3306,
            1.5,
        ),
        (
            "grasp20_even/grasps.csv",
            vec!["f1_z"],
            Some("sample"),
            1.0,
            0.001,
            0.02,
        ),
        (
            "fruit_training/traces.csv",
            vec!["force_N"],
            Some("trial"),
            1.0,
            0.0001,
            0.05,
        ),
        (
            "biotacsp_dos_basic/basic.csv",
            vec!["ff_e1"],
            Some("sequence"),
            1.0,
            1.0,
            20.0,
        ),
    ];
    for (file, reading, group, newtons_per_unit, step, noise_most) in checks {
        let Some(path) = shared(file) else { continue };
        let arguments = CalibrateModel {
            group: group.map(str::to_owned),
            newtons_per_unit,
            ..arguments(&path, &reading)
        };
        let report = report(&arguments).expect(file);
        let found = report.model.step_n[0];
        assert!((found / step - 1.0).abs() < 0.01, "{file}: step {found}");
        assert!(report.model.noise_n[0] <= noise_most, "{file}: {report:?}");
        assert!(report.residual_n.is_none() && report.model.hysteresis.is_none());
        assert!(
            report
                .not_identified
                .iter()
                .any(|why| why.starts_with("hysteresis"))
        );
    }
}

#[test]
fn unusable_recordings_are_rejected_with_a_remedy() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("short.csv");
    let check = |text: &str, change: &dyn Fn(&mut CalibrateModel), part: &str| {
        std::fs::write(&path, text).expect("written");
        let mut arguments = arguments(&path, &["v"]);
        change(&mut arguments);
        let refused = format!("{:#}", report(&arguments).expect_err(part));
        assert!(refused.contains(part), "{refused}");
    };
    let rows = |row: &dyn Fn(usize) -> String| {
        (0..200).fold("t_s,v,force_n\n".to_owned(), |text, k| text + &row(k))
    };
    let good = rows(&|k| format!("{},{},{}\n", k, k % 7, k % 5));
    check("t_s,v\n0,1\n", &|_| (), "needs 100; record longer");
    check(
        &good,
        &|a| a.reading = vec!["w".to_owned()],
        "could not find the column \"w\"",
    );
    check(
        &good,
        &|a| a.force = Some("f".to_owned()),
        "it has t_s, v, force_n",
    );
    check(
        &rows(&|k| format!("{k},x,1\n")),
        &|_| (),
        "a reading is not a number",
    );
    check(
        &rows(&|k| format!("{},1,1\n", 200 - k)),
        &|_| (),
        "sort the rows",
    );
    check(
        &rows(&|k| format!("{k},{},\n", k % 3)),
        &|_| (),
        "its column has no number",
    );
    check(
        &rows(&|k| format!("{k},1,{}\n", k % 3)),
        &|_| (),
        "do not change with the force",
    );
}
