//! `atas calibrate model`: fits a sensor model for the simulator to a recording.
//!
//! The first half of the recording determines the model; the second half measures its residual.
//! Without a true force only noise, resolution and range can be determined. An effect counts as
//! identified if the residual of the first half grows by 5 % or more without it.

mod print;
mod quiet;
mod response;
mod series;
#[cfg(test)]
mod tests;

use anyhow::Context;
use atas_console::arguments::CalibrateModel;
use atas_console::{Exit, ExitError, Output};
use atas_evaluation::recorded::Sheet;
use serde::Serialize;
use sim_backend::{CreepModel, DriftModel, FrameModel, HysteresisModel, SensorModel};

use super::domain::{self, Checked};
use print::{model_file, print};
use quiet::Column;
use response::{Effects, Response, Search};
use series::Series;

/// Growth of the residual without an effect from which the effect counts as identified (design
/// choice).
const WORTH: f64 = 1.05;
/// Share of full scale below which a force counts as none.
const UNLOADED_SHARE: f64 = 0.01;
/// Fewest unloaded rows that determine a drift (design choice).
const UNLOADED_ROWS: usize = 50;

/// Result, as JSON.
#[derive(Debug, Serialize)]
pub(super) struct Report {
    recording: String,
    rows: usize,
    seconds: f64,
    rate_hz: f64,
    columns: Vec<ColumnReport>,
    /// Root mean square of reading minus model on the half that was not used, N.
    #[serde(skip_serializing_if = "Option::is_none")]
    residual_n: Option<f64>,
    /// Same on the half that was used, N.
    #[serde(skip_serializing_if = "Option::is_none")]
    fitted_n: Option<f64>,
    effects: Vec<EffectReport>,
    #[serde(skip_serializing_if = "Option::is_none")]
    accuracy_n: Option<f64>,
    /// Effects that this recording cannot determine, with the reason.
    not_identified: Vec<String>,
    model: SensorModel,
    /// Comparison with the domain of validity, if requested.
    #[serde(skip_serializing_if = "Option::is_none")]
    domain: Option<Vec<Checked>>,
}

#[derive(Debug, Serialize)]
struct ColumnReport {
    name: String,
    step: f64,
    noise: f64,
    largest: f64,
    saturates: bool,
}

#[derive(Debug, Serialize)]
struct EffectReport {
    name: &'static str,
    value: f64,
    unit: &'static str,
    /// Residuals of both halves without this effect, N.
    without_n: [f64; 2],
    identified: bool,
}

pub(super) fn fit_model(arguments: &CalibrateModel, output: &mut Output) -> anyhow::Result<()> {
    let report = report(arguments)
        .map_err(|error| ExitError::with_code(Exit::Failed, format!("{error:#}")))?;
    if let Some(path) = &arguments.out {
        super::write_new(path, &model_file(&report)?)?;
    }
    if output.is_json() {
        output.json(&report)?;
    } else {
        print(&report, output)?;
        if let Some(path) = &arguments.out {
            output.line(format_args!("wrote {}", path.display()))?;
        }
    }
    let outside = report.domain.iter().flatten().filter(|it| !it.valid);
    let outside: Vec<&str> = outside.map(|it| it.name.as_str()).collect();
    match outside.is_empty() {
        true => Ok(()),
        false => Err(ExitError::with_code(
            Exit::Failed,
            format!(
                "the sensor is outside the domain in which grasps were validated: {}; improve the \
                 sensor or evaluate the controller with --sensor-model",
                outside.join(", ")
            ),
        )),
    }
}

pub(super) fn report(arguments: &CalibrateModel) -> anyhow::Result<Report> {
    let sheet = Sheet::open(&arguments.recording)?;
    let series = Series::read(&sheet, arguments)?;
    let mut report = fit(&series, arguments)?;
    if arguments.check_domain {
        report.domain = Some(domain::check(&report.model)?);
    }
    Ok(report)
}

fn fit(series: &Series, arguments: &CalibrateModel) -> anyhow::Result<Report> {
    let path = arguments.recording.display().to_string();
    let columns: Vec<Column> = (0..series.readings[0].len())
        .map(|column| Column::measure(series, column))
        .collect();
    let mut report = Report {
        rows: series.time_s.len(),
        seconds: series
            .ranges()
            .iter()
            .map(|of| duration_s(series, of))
            .sum(),
        rate_hz: 1.0 / series.period_s().max(1e-9),
        columns: column_reports(arguments, &columns),
        residual_n: None,
        fitted_n: None,
        effects: Vec::new(),
        accuracy_n: arguments.accuracy,
        not_identified: Vec::new(),
        domain: None,
        model: SensorModel {
            about: format!("fitted to {path}"),
            gain_spread: 0.0,
            noise_ratio: 0.0,
            ..SensorModel::default()
        },
        recording: path,
    };
    report.set_rate(series);
    if series.force_n.is_empty() {
        report.set_quiet(&columns, &vec![arguments.newtons_per_unit; columns.len()]);
        let missing = "the recording has no true force; name its column with --force";
        let effects = ["gain", "latency", "hysteresis", "creep", "drift"];
        report
            .not_identified
            .extend(effects.map(|effect| format!("{effect}: {missing}")));
    } else {
        report.set_response(series, &columns)?;
    }
    let several = "needs several elements or sensors, or a recording over months";
    report.not_identified.push(format!(
        "gain spread, crosstalk, dead elements, wear: {several}"
    ));
    report
        .model
        .check()
        .context("could not use the fitted model")?;
    Ok(report)
}

fn duration_s(series: &Series, group: &core::ops::Range<usize>) -> f64 {
    series.time_s[group.end - 1] - series.time_s[group.start]
}

fn column_reports(arguments: &CalibrateModel, columns: &[Column]) -> Vec<ColumnReport> {
    let named = arguments.reading.iter().zip(columns);
    named
        .map(|(name, column)| ColumnReport {
            name: name.clone(),
            step: column.step,
            noise: column.noise,
            largest: column.largest,
            saturates: column.saturates,
        })
        .collect()
}

impl Report {
    fn set_rate(&mut self, series: &Series) {
        if !series.has_times {
            let why = "the recording has no times; its rate is that of --rate-hz";
            self.not_identified.push(format!("rate, latency: {why}"));
        }
        let rate_hz = self.rate_hz.round();
        self.model.rate_hz = (1.0..=1000.0).contains(&rate_hz).then_some(rate_hz as u32);
    }

    /// Sets noise, step and saturation from the columns, in N by their factors.
    fn set_quiet(&mut self, columns: &[Column], newtons_per_unit: &[f64]) {
        let scaled = |of: fn(&Column) -> f64| {
            let values = columns.iter().zip(newtons_per_unit);
            values
                .map(move |(column, factor)| of(column) * factor.abs())
                .fold(0.0, f64::max)
        };
        let noise_n = scaled(|column| column.noise);
        self.model.noise_n = [noise_n; 2];
        let step_n = scaled(|column| column.step);
        if step_n > 0.0 {
            self.model.step_n = [step_n; 2];
        }
        if columns.iter().any(|column| column.saturates) {
            let largest_n = scaled(|column| column.largest);
            self.model.saturation_n = (largest_n > 0.0).then_some([largest_n; 2]);
        } else {
            self.not_identified
                .push("saturation: no reading stays at its largest value".to_owned());
        }
    }

    /// Fits the response to the true force.
    fn set_response(&mut self, series: &Series, columns: &[Column]) -> anyhow::Result<()> {
        let undetermined = "could not determine the gain: the readings of the first half do not \
                            change with the force; record presses in both halves";
        let search = Search::new(series).context(undetermined)?;
        let best = search.best([true; 3]).context(undetermined)?;
        let names = [
            ("latency", "s"),
            ("hysteresis", ""),
            ("creep per decade", ""),
        ];
        let mut kept = [true; 3];
        for (effect, (name, unit)) in names.into_iter().enumerate() {
            let mut free = [true; 3];
            free[effect] = false;
            let without = search.best(free).context(undetermined)?;
            kept[effect] = without.rms_n[0] >= WORTH * best.rms_n[0];
            self.effects.push(EffectReport {
                name,
                value: value(&best.effects, effect),
                unit,
                without_n: without.rms_n,
                identified: kept[effect],
            });
        }
        // The model contains the identified effects only.
        let best = search.best(kept).context(undetermined)?;
        for (effect, report) in self
            .effects
            .iter_mut()
            .enumerate()
            .filter(|(k, _)| kept[*k])
        {
            report.value = value(&best.effects, effect);
        }
        self.set_quiet(columns, &best.newtons_per_unit);
        self.set_noise(series, &best);
        self.set_effects(&best, kept);
        self.set_drift(series, &best);
        (self.fitted_n, self.residual_n) = (Some(best.rms_n[0]), Some(best.rms_n[1]));
        Ok(())
    }

    /// Sets the noise of the calibrated reading; that of single columns is correlated.
    fn set_noise(&mut self, series: &Series, best: &Response) {
        let calibrated = Series {
            readings: best.reading_n.iter().map(|n| vec![*n]).collect(),
            ..series.clone()
        };
        self.model.noise_n = [Column::measure(&calibrated, 0).noise; 2];
    }

    fn set_effects(&mut self, best: &Response, kept: [bool; 3]) {
        let Effects {
            latency_s,
            hysteresis,
            creep_per_decade,
        } = best.effects;
        for (effect, of) in self.effects.iter().enumerate().filter(|(k, _)| !kept[*k]) {
            let without_n = self.effects[effect].without_n[0];
            self.not_identified.push(format!(
                "{}: without it the residual of the fitted half is {without_n:.4} N, less than 5 % \
                 more",
                of.name
            ));
        }
        if kept[0] && latency_s < 0.0 {
            self.not_identified.push(format!(
                "latency: the reference is {:.0} ms later than the sensor",
                -1e3 * latency_s
            ));
        } else if kept[0] {
            let latency_s = latency_s.min(0.5);
            self.model.frames = FrameModel {
                latency_s,
                ..FrameModel::default()
            };
        }
        let full_scale_n = [best.full_scale_n; 2];
        self.model.hysteresis = kept[1].then_some(HysteresisModel {
            share: hysteresis,
            full_scale_n,
        });
        self.model.creep = kept[2].then_some(CreepModel {
            per_decade: creep_per_decade,
        });
    }

    /// Sets the drift of the unloaded reading in the first half.
    fn set_drift(&mut self, series: &Series, best: &Response) {
        let unloaded_n = UNLOADED_SHARE * best.full_scale_n;
        let rows: Vec<usize> = (0..series.time_s.len() / 2)
            .filter(|row| series.force_n[*row].abs() <= unloaded_n)
            .collect();
        let spread_s = match (rows.first(), rows.last()) {
            (Some(first), Some(last)) => series.time_s[*last] - series.time_s[*first],
            _ => 0.0,
        };
        if rows.len() < UNLOADED_ROWS || spread_s <= 0.0 {
            let why = format!(
                "{} unloaded rows in the first half, needs {UNLOADED_ROWS}",
                rows.len()
            );
            self.not_identified.push(format!("drift: {why}"));
            return;
        }
        let slope_n_s = slope(
            rows.iter()
                .map(|row| (series.time_s[*row], best.residual_n[*row])),
        );
        let noise_n = self.model.noise_n[0];
        if (slope_n_s * spread_s).abs() < noise_n {
            let why = format!("less than the noise of {noise_n:.4} N in {spread_s:.0} s");
            self.not_identified.push(format!("drift: {why}"));
            return;
        }
        self.model.drift = Some(DriftModel {
            rate_n_s: [slope_n_s.clamp(-100.0, 100.0), 0.0, 0.0],
            limit_n: (slope_n_s * spread_s).abs().min(1e4),
            from_s: 0.0,
        });
    }
}

fn value(effects: &Effects, effect: usize) -> f64 {
    [
        effects.latency_s,
        effects.hysteresis,
        effects.creep_per_decade,
    ][effect]
}

/// Returns the slope of the line of least squares.
fn slope(points: impl Iterator<Item = (f64, f64)> + Clone) -> f64 {
    let count = points.clone().count() as f64;
    let sum = |of: fn((f64, f64)) -> f64| points.clone().map(of).sum::<f64>();
    let (mean_x, mean_y) = (sum(|(x, _)| x) / count, sum(|(_, y)| y) / count);
    let (mut along, mut square) = (0.0, 0.0);
    for (x, y) in points {
        along += (x - mean_x) * (y - mean_y);
        square += (x - mean_x) * (x - mean_x);
    }
    if square > 0.0 { along / square } else { 0.0 }
}
