//! Report of a fitted sensor model as text, and its file.

use std::fmt::Write as _;

use anyhow::ensure;
use atas_console::{Output, table};

use super::super::domain::{Checked, LAYOUT};
use super::Report;

/// Returns the text of a model file, with the residual as a comment.
pub(super) fn model_file(report: &Report) -> anyhow::Result<String> {
    let mut text = format!(
        "# Fitted by `atas calibrate model` to {}.\n",
        report.recording
    );
    if let Some(residual_n) = report.residual_n {
        writeln!(
            text,
            "# Residual on the half that was not used: {residual_n:.4} N."
        )?;
    }
    for reason in &report.not_identified {
        writeln!(text, "# Not identified: {reason}.")?;
    }
    Ok(text + &report.model.to_toml()?)
}

pub(super) fn print(report: &Report, output: &mut Output) -> anyhow::Result<()> {
    let Report {
        rows,
        seconds,
        rate_hz,
        ..
    } = report;
    output.line(format_args!("{rows} rows, {seconds:.1} s, {rate_hz:.1} Hz"))?;
    let mut columns = table(&["reading", "step", "noise", "largest", "saturates"]);
    for of in &report.columns {
        let saturates = if of.saturates { "yes" } else { "no" };
        columns.add_row([
            of.name.clone(),
            format!("{:.4}", of.step),
            format!("{:.4}", of.noise),
            format!("{:.4}", of.largest),
            saturates.to_owned(),
        ]);
    }
    output.table(columns)?;
    if !report.effects.is_empty() {
        let mut effects = table(&["effect", "value", "identified", "residual without it N"]);
        for of in &report.effects {
            let [fitted_n, held_out_n] = of.without_n;
            effects.add_row([
                of.name.to_owned(),
                format!("{:.4} {}", of.value, of.unit),
                if of.identified { "yes" } else { "no" }.to_owned(),
                format!("{fitted_n:.4} fitted, {held_out_n:.4} held out"),
            ]);
        }
        output.table(effects)?;
    }
    let model = &report.model;
    output.line(format_args!(
        "noise {:.4} N, step {:.4} N",
        model.noise_n[0], model.step_n[0]
    ))?;
    if let Some(drift) = &model.drift {
        output.line(format_args!("drift {:.2e} N/s", drift.rate_n_s[0]))?;
    }
    if let (Some(fitted_n), Some(residual_n)) = (report.fitted_n, report.residual_n) {
        output.line(format_args!(
            "residual {residual_n:.4} N on the half that was not used, {fitted_n:.4} N on the other"
        ))?;
        if let Some(accuracy_n) = report.accuracy_n {
            let relation = if residual_n <= accuracy_n {
                "within"
            } else {
                "worse than"
            };
            output.line(format_args!(
                "{relation} the stated accuracy of {accuracy_n} N"
            ))?;
        }
    }
    for reason in &report.not_identified {
        output.line(format_args!("not identified: {reason}"))?;
    }
    if let Some(domain) = &report.domain {
        print_domain(domain, model.layout.as_deref(), output)?;
    }
    ensure!(
        model.step_n[0] > 0.0,
        "could not fit a model: the readings never change"
    );
    Ok(())
}

fn print_domain(
    domain: &[Checked],
    layout: Option<&str>,
    output: &mut Output,
) -> anyhow::Result<()> {
    let mut rows = table(&["property", "value", "valid", "within", "failure beyond"]);
    for of in domain {
        let limit = |bound: Option<f64>| bound.map_or("…".to_owned(), |bound| bound.to_string());
        rows.add_row([
            of.name.clone(),
            format!("{:.3} {}", of.value, of.unit),
            format!("{} to {}", limit(of.low), limit(of.high)),
            if of.valid { "yes" } else { "no" }.to_owned(),
            of.failure.clone().unwrap_or_default(),
        ]);
    }
    output.table(rows)?;
    if layout == Some(LAYOUT) {
        return Ok(());
    }
    output.line(format_args!(
        "valid ranges hold for each element of {LAYOUT}; a sensor with fewer elements may differ"
    ))
}
