//! `atas calibrate`: fits a calibration to recorded silence and presses; reports its errors and
//! writes the daemon's settings. `model.rs` fits a sensor model for the simulator.

mod domain;
pub(crate) mod guide;
mod model;
mod rows;

use std::fmt::Write as _;
use std::path::Path;

use anyhow::{Context, anyhow, ensure};
use atas_console::arguments::{Calibrate, CalibrateFit, CalibrationModel};
use atas_console::{Exit, ExitError, Interrupt, Output, table};
use atas_core::Settings;
use atas_evaluation::recorded::{Sheet, greatest_motion};
use atas_evaluation::{figures, median};
use atas_sensors::calibration::{
    Block, Calibration, Drift, FitResult, Model, Thresholds, UnloadedRecording, WARMING_MIN_K, fit,
    fit_block, measure_silence,
};
use serde::Serialize;
use shm_schemas::layout::NamedLayout;
use shm_schemas::{Hand, Layout};

use crate::picture;

/// Ratio of the motion threshold to the largest motion measure of an unloaded sensor (design
/// choice; a stable contact moves more than an unloaded sensor).
const MOTION_CLEARANCE: f64 = 1.5;

/// Sensor periods until a frame is too old (design choice, as in the guide: one lost frame must not
/// cause a hold).
const HOLD_PERIODS: f64 = 3.5;
/// Largest frame age that the daemon accepts, s.
const HOLD_MAX_S: f64 = 0.5;
/// Sensor rates that the daemon accepts, Hz.
const RATES_HZ: [f64; 2] = [1.0, 10_000.0];

#[derive(Serialize)]
pub(crate) struct Report {
    calibration: String,
    model: Model,
    elements: usize,
    presses: u32,
    #[serde(skip_serializing_if = "Option::is_none")]
    ridge: Option<f64>,
    error_n: [f64; 3],
    error_share: [f64; 3],
    thresholds: Thresholds,
    motion_at: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    drift: Option<Drift>,
    #[serde(skip_serializing_if = "Option::is_none")]
    block: Option<Block>,
    warnings: Vec<String>,
}

pub(crate) fn calibrate(
    action: &Calibrate,
    interrupt: &Interrupt,
    output: &mut Output,
) -> anyhow::Result<()> {
    match action {
        Calibrate::Guide(arguments) => guide::guide(arguments, interrupt, output),
        Calibrate::Model(arguments) => model::fit_model(arguments, output),
        Calibrate::Fit(arguments) => {
            let report = fit_files(arguments)
                .map_err(|error| ExitError::with_code(Exit::Failed, format!("{error:#}")))?;
            if output.is_json() {
                return output.json(&report);
            }
            print(&report, output)
        }
    }
}

pub(crate) fn fit_files(arguments: &CalibrateFit) -> anyhow::Result<Report> {
    let layout = Layout::from_name(&arguments.layout).with_context(|| {
        format!(
            "could not use the layout {:?}: needs {}",
            arguments.layout,
            NamedLayout::FORMS
        )
    })?;
    let (mut fitted, quiet, seconds, rate_hz) = fitted(arguments, &layout)?;
    let motion_at = motion_threshold(&fitted.calibration, &quiet.frames, seconds);
    let thresholds = Thresholds::from_recording(
        &fitted.calibration,
        &quiet.frames,
        seconds,
        arguments.multiple,
    )
    .context(
        "could not determine the noise: too little silence; record the untouched sensor \
            for some seconds and name the file with --silence",
    )?;
    fitted.calibration.quality.noise_n = thresholds.noise_n;
    fitted.calibration.quality.drift_n_min = thresholds.drift_n_min;
    fitted.calibration.drift = Drift::from_recording(&fitted.calibration, &quiet);
    let block = match &arguments.block {
        Some(path) => Some(block(path, thresholds.touch_on_n, arguments.block_tips)?),
        None => None,
    };
    let mut reported = sensor_config(arguments, rate_hz)?;
    reported += &perception_config(&thresholds, motion_at, block.as_ref())?;
    fitted.calibration.save(&arguments.out)?;
    if let Some(path) = &arguments.daemon {
        write_new(path, &reported)?;
    }
    if let Some(path) = &arguments.figure {
        let title = format!("errors of {}", arguments.out.display());
        picture::write(path, &figures::residuals(&title, &fitted.residuals)?)?;
    }
    let quality = fitted.calibration.quality;
    Ok(Report {
        calibration: arguments.out.display().to_string(),
        model: fitted.calibration.model,
        elements: fitted.calibration.elements_in(),
        presses: quality.presses,
        ridge: quality.ridge,
        error_n: quality.error_n,
        error_share: quality.error_share,
        warnings: warnings(&fitted, &thresholds, &quiet, seconds),
        thresholds,
        motion_at,
        drift: fitted.calibration.drift,
        block,
    })
}

/// Returns the calibration, the silence with its duration, s, and the sensor rate, Hz, if the
/// presses have times.
fn fitted(
    arguments: &CalibrateFit,
    layout: &Layout,
) -> anyhow::Result<(FitResult, UnloadedRecording, f64, Option<f64>)> {
    let sheet = Sheet::open(&arguments.presses)?;
    let recording = rows::recording(&sheet)?;
    let reference = arguments
        .reference
        .as_deref()
        .map(Sheet::open)
        .transpose()?;
    let (presses, mut quiet) = rows::presses(&sheet, &recording, reference.as_ref())?;
    let mut seconds = duration_s(
        recording.times_ns.as_deref(),
        quiet.frames.len(),
        recording.frames.len(),
    );
    if let Some(path) = &arguments.silence {
        let silence = rows::recording(&Sheet::open(path)?)?;
        let frames = silence.frames.len();
        seconds = duration_s(silence.times_ns.as_deref(), frames, frames);
        quiet = silence.quiet(0..frames);
    }
    let silence = measure_silence(&quiet.frames).with_context(|| {
        format!(
            "could not determine zero and noise: {} silent frames, needs some seconds; name a \
            recording with --silence",
            quiet.frames.len()
        )
    })?;
    let model = match arguments.model {
        Some(CalibrationModel::Matrix) => Model::Matrix,
        Some(CalibrationModel::Resultant) => Model::Resultant,
        Some(CalibrationModel::ResultantSquares) => Model::ResultantSquares,
        None if recording.is_flux => Model::ResultantSquares,
        None => Model::Matrix,
    };
    let source = format!("{} presses of {}", presses.len(), sheet.path.display());
    Ok((
        fit(&presses, &silence, model, layout, &source)?,
        quiet,
        seconds,
        recording.times_ns.as_deref().and_then(frame_rate_hz),
    ))
}

fn frame_rate_hz(times_ns: &[f64]) -> Option<f64> {
    let steps_ns = times_ns.windows(2).map(|pair| pair[1] - pair[0]);
    let step_ns = median(steps_ns.filter(|step_ns| *step_ns > 0.0).collect())?;
    Some(1e9 / step_ns)
}

fn duration_s(times_ns: Option<&[f64]>, some: usize, all: usize) -> f64 {
    let span_ns = times_ns.and_then(|times| Some(times.last()? - times.first()?));
    match span_ns {
        Some(span_ns) if span_ns > 0.0 => span_ns * 1e-9 * some as f64 / all.max(1) as f64,
        _ => some as f64 / rows::DEFAULT_RATE_HZ,
    }
}

fn motion_threshold(calibration: &Calibration, quiet: &[Vec<f64>], seconds: f64) -> f64 {
    let frames: Vec<Vec<[f64; 3]>> = quiet
        .iter()
        .map(|values| {
            let elements = 0..calibration.elements_out();
            elements
                .map(|element| calibration.force_n(element, values))
                .collect()
        })
        .collect();
    let step_s = seconds / quiet.len().max(1) as f64;
    let usual = Settings::default().perception.motion_at;
    (MOTION_CLEARANCE * greatest_motion(&frames, step_s)).max(usual)
}

fn block(path: &Path, from_n: f64, tips: u32) -> anyhow::Result<Block> {
    let sheet = Sheet::open(path)?;
    let (closing, force) = (sheet.column("closing_m"), sheet.column("normal_n"));
    let point = |row: usize| Some((sheet.number(row, closing?)?, sheet.number(row, force?)?));
    let points: Vec<(f64, f64)> = (0..sheet.len()).filter_map(point).collect();
    fit_block(&points, from_n, tips).with_context(|| {
        format!(
            "could not fit the fingertip compression to {} rows of {}: needs closing_m and \
             normal_n of presses on a rigid object, at least 10 rows above {from_n:.3} N",
            points.len(),
            path.display()
        )
    })
}

/// Returns the daemon's sensor settings: largest frame age, and for a named hand its layout and
/// rate.
fn sensor_config(arguments: &CalibrateFit, rate_hz: Option<f64>) -> anyhow::Result<String> {
    let mut text =
        "# Made by atas calibrate. Use: atasd --config THIS, after your own configuration.\n"
            .to_owned();
    let rate_hz = rate_hz.map(|rate_hz| rate_hz.clamp(RATES_HZ[0], RATES_HZ[1]));
    if let Some(hand) = arguments.hand {
        let (hand, layout) = (Hand::from(hand).name(), &arguments.layout);
        writeln!(text, "[hands.{hand}]\nlayout = {layout:?}")?;
        if let Some(rate_hz) = rate_hz {
            writeln!(text, "rate_hz = {rate_hz:.1}")?;
        }
        text.push('\n');
    }
    let Some(rate_hz) = rate_hz else {
        return Ok(text);
    };
    let usual = Settings::default().intake;
    let age_s = HOLD_PERIODS / rate_hz;
    if age_s > usual.hold_age_s {
        writeln!(text, "[intake]\nhold_age_s = {:.4}", age_s.min(HOLD_MAX_S))?;
        if age_s >= usual.reject_age_s {
            writeln!(text, "reject_age_s = {:.4}", 2.0 * age_s.min(HOLD_MAX_S))?;
        }
        text.push('\n');
    }
    Ok(text)
}

/// Returns the daemon's perception settings, clamped to their ranges.
fn perception_config(
    thresholds: &Thresholds,
    motion_at: f64,
    block: Option<&Block>,
) -> anyhow::Result<String> {
    let mut settings = Settings::default();
    // Set the lower threshold to 0 first: every order of the two thresholds is then valid.
    let mut reported = vec![
        ("touch_off_n", 0.0),
        ("touch_on_n", thresholds.touch_on_n),
        ("touch_off_n", thresholds.touch_off_n),
        ("element_floor_n", thresholds.element_floor_n),
        ("motion_at", motion_at),
    ];
    if let Some(block) = block {
        reported.push(("tip_compression_m", block.tip_compression_m));
        reported.push(("tip_exponent", block.tip_exponent));
    }
    for &(key, value) in &reported {
        let name = format!("perception.{key}");
        let known = atas_core::settings::find(&name);
        let known = known.with_context(|| format!("{name} is not a parameter"))?;
        let value = value.clamp(known.lower, known.upper);
        settings
            .set(&name, value)
            .map_err(|error| anyhow!("{error}"))?;
    }
    let mut text = "[perception]\n".to_owned();
    for (key, _) in &reported[1..] {
        let name = format!("perception.{key}");
        let value = atas_core::settings::find(&name).map(|known| (known.get)(&settings));
        let value = value.with_context(|| format!("{name} is not a parameter"))?;
        writeln!(text, "{key} = {value:?}").context("could not write")?;
    }
    Ok(text)
}

fn warnings(
    fitted: &FitResult,
    thresholds: &Thresholds,
    quiet: &UnloadedRecording,
    seconds: f64,
) -> Vec<String> {
    let quality = &fitted.calibration.quality;
    let mut warnings = Vec::new();
    for (axis, share) in ["normal", "tangential1", "tangential2"]
        .iter()
        .zip(quality.error_share)
    {
        if share > 0.1 {
            warnings.push(format!(
                "the error along {axis} is {:.0} % of the pressed force; record more presses, or \
                 check the reference",
                100.0 * share
            ));
        }
    }
    if thresholds.drift_n_min > thresholds.touch_off_n - thresholds.drift_n_min {
        warnings.push(format!(
            "the zero drifts by {:.3} N/min, more than the noise: let the sensor warm up, and take \
             its zero before each use",
            thresholds.drift_n_min
        ));
    }
    if let Some(drift) = &fitted.calibration.drift {
        warnings.extend(drift_warnings(drift, thresholds, quiet));
    }
    if seconds < 10.0 {
        warnings.push(format!(
            "drift was measured for {seconds:.0} s only; record a minute of silence for a better \
             estimate"
        ));
    }
    warnings
}

/// Returns warnings about drift that could be mistaken for contact.
fn drift_warnings(
    drift: &Drift,
    thresholds: &Thresholds,
    quiet: &UnloadedRecording,
) -> Vec<String> {
    let mut warnings = Vec::new();
    let floor_n = thresholds.element_floor_n;
    let (worst, most_n) = drift.worst();
    let moving = drift.element_n_min.iter().filter(|n| **n > floor_n).count();
    if moving > 0 {
        warnings.push(format!(
            "{moving} of {} elements drift by more than {floor_n:.4} N/min, the element threshold; \
             worst is element {worst} with {most_n:.4} N/min",
            drift.element_n_min.len()
        ));
    }
    // The contact threshold already includes noise and drift.
    let felt_n = thresholds.touch_on_n - thresholds.drift_n_min;
    match &drift.warmth {
        Some(warmth) if warmth.largest_total_n_k() > felt_n => warnings.push(format!(
            "a temperature change of 1 K changes the force by {:.4} N, more than the contact \
             threshold of {felt_n:.4} N: take the zero at operating temperature",
            warmth.largest_total_n_k()
        )),
        None if !quiet.temperatures_c.is_empty() => warnings.push(format!(
            "the temperature changed by less than {WARMING_MIN_K} K: its effect is unknown; record \
             silence while the sensor warms up"
        )),
        _ => {}
    }
    warnings
}

fn write_new(path: &Path, text: &str) -> anyhow::Result<()> {
    let name = path.display();
    let mut file = std::fs::File::create_new(path).with_context(|| {
        format!(
            "could not create {name}: existing files are not overwritten; \
            name a new file"
        )
    })?;
    std::io::Write::write_all(&mut file, text.as_bytes())
        .with_context(|| format!("could not write {name}"))
}

fn print(report: &Report, output: &mut Output) -> anyhow::Result<()> {
    let mut rows = table(&["axis", "error N", "relative error", "noise N"]);
    for (axis, name) in ["normal", "tangential1", "tangential2"].iter().enumerate() {
        rows.add_row([
            (*name).to_owned(),
            format!("{:.4}", report.error_n[axis]),
            format!("{:.1} %", 100.0 * report.error_share[axis]),
            format!("{:.4}", report.thresholds.noise_n[axis]),
        ]);
    }
    output.table(rows)?;
    let thresholds = &report.thresholds;
    output.line(format_args!(
        "contact from {:.4} N, until {:.4} N; motion from {:.2} times the noise; drift {:.4} N/min",
        thresholds.touch_on_n, thresholds.touch_off_n, report.motion_at, thresholds.drift_n_min
    ))?;
    if let Some(ridge) = report.ridge {
        output.line(format_args!(
            "ridge {ridge:e}, relative to the variance of each term: best value on held-out presses"
        ))?;
    }
    if let Some(drift) = &report.drift {
        let (worst, most_n) = drift.worst();
        output.line(format_args!(
            "largest drift: element {worst}, {most_n:.4} N/min, measured for {:.0} s",
            drift.watched_s
        ))?;
        if let Some(warmth) = &drift.warmth {
            let [n, a, b] = warmth.total_n_k;
            output.line(format_args!(
                "1 K changes the total force by {n:.4} {a:.4} {b:.4} N; the temperature changed by \
                 {:.1} K",
                warmth.span_k
            ))?;
        }
    }
    if let Some(block) = &report.block {
        output.line(format_args!(
            "compression of each fingertip: {:.0} µm at 1 N, exponent {:.2}, error {:.1} µm",
            1e6 * block.tip_compression_m,
            block.tip_exponent,
            1e6 * block.error_m
        ))?;
    }
    for warning in &report.warnings {
        output.line(format_args!("warning: {warning}"))?;
    }
    ensure!(
        report.presses > 0,
        "no calibration result: the recording contains no press; record \
        presses with known forces"
    );
    output.line(format_args!(
        "wrote {}: {} elements, errors from held-out presses, {} in total",
        report.calibration, report.elements, report.presses
    ))
}
