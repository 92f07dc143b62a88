//! `atas eval recording`: evaluates slip or force models on recordings and prints the result.

use std::path::Path;

use atas_console::arguments::RecordedEvaluation;
use atas_console::{Exit, ExitError, Output, table};
use atas_evaluation::recorded::{Fit, Labels, Model, Rates, Verdict, evaluate, open, train};
use comfy_table::Cell;

pub(super) fn evaluate_recording(
    arguments: &RecordedEvaluation,
    output: &mut Output,
) -> anyhow::Result<()> {
    let verdict =
        run(arguments).map_err(|error| ExitError::with_code(Exit::Failed, format!("{error:#}")))?;
    if output.is_json() {
        return output.json(&verdict);
    }
    print(&arguments.file, &verdict, output)
}

fn run(arguments: &RecordedEvaluation) -> anyhow::Result<Verdict> {
    let labels = Labels {
        column: arguments.labels.clone(),
        file: arguments.labels_file.clone(),
        positive: arguments.positive.clone(),
        negative: arguments.negative.clone(),
        objects: arguments.objects.clone(),
    };
    let mut model = match &arguments.model {
        Some(path) => Model::open(path)?,
        None => Model::built_in()?,
    };
    if let Some(rate_hz) = arguments.rate_hz {
        model = model.with_rate(rate_hz);
    }
    if let Some(path) = &arguments.train {
        // Row numbers of the label file are valid for one recording only.
        let own = Labels {
            file: None,
            ..labels.clone()
        };
        let (sheet, own) = open(path, &own)?;
        model = train(&sheet, &own, &model)?;
    }
    if let Some(path) = &arguments.save {
        model.save(path)?;
    }
    let fit = if arguments.cross_validate {
        Fit::Across
    } else {
        Fit::Given
    };
    let (sheet, labels) = open(&arguments.file, &labels)?;
    evaluate(&sheet, &labels, &model, fit)
}

fn print(file: &Path, verdict: &Verdict, output: &mut Output) -> anyhow::Result<()> {
    let mut rates = table(&["", "balanced accuracy", "specificity", "sensitivity", "AUC"]);
    let mut rows = 0;
    let mut add = |name: String, of: &Rates| {
        let figures = [of.balanced_accuracy, of.specificity, of.sensitivity, of.auc];
        let cells = figures.map(|figure| Cell::from(format!("{figure:.3}")));
        rates.add_row([Cell::from(name)].into_iter().chain(cells));
        rows += 1;
    };
    if let Some(of) = &verdict.rates {
        add("all".to_owned(), of);
    }
    if let Some(of) = &verdict.first_step {
        add("first step after contact".to_owned(), of);
    }
    for after in &verdict.after {
        add(format!("after {} s", after.s), &after.rates);
    }
    if rows > 0 {
        output.table(rates)?;
    }
    if !verdict.sorts.is_empty() {
        let mut errors = table(&[
            "",
            "presses",
            "error N",
            "error of mean N",
            "known, excess N",
        ]);
        for (sort, of) in &verdict.sorts {
            errors.add_row([
                sort.clone(),
                of.n.to_string(),
                format!("{:.3}", of.mae_n),
                format!("{:.3}", of.mae_of_mean_n),
                format!("{:.2}", of.beyond_n),
            ]);
        }
        output.table(errors)?;
    }
    if let Some(touches) = &verdict.touches {
        output.line(format_args!(
            "{} contacts, starting in rows {touches:?}",
            touches.len()
        ))?;
    }
    for warning in &verdict.warnings {
        output.line(format_args!("warning: {warning}"))?;
    }
    let constants = match verdict.fit {
        Fit::Given => "constants of the model",
        Fit::Across => "constants fitted to the other objects",
    };
    output.line(format_args!(
        "{}: {} evaluated, {} objects, {} without a usable label; {constants}",
        file.display(),
        verdict.n,
        verdict.objects,
        verdict.skipped
    ))
}
