//! Results of a demo as table or JSON.

use atas_console::{Exit, ExitError, Output, no_break, table};
use comfy_table::{Cell, Table};
use serde_json::{Map, Value};

use crate::observed::ObservedRun;
use crate::punctuality::Punctuality;
use crate::scenario::{Evaluation, Figure};

pub(crate) struct Row {
    name: String,
    judged: Evaluation,
    /// Reason of the failure; empty on success.
    reason: String,
    punctuality: Punctuality,
}

impl Row {
    pub(crate) fn new(name: &str, judged: Evaluation, seen: &ObservedRun) -> Self {
        let reason = if seen.progress.last().reason.is_some() {
            seen.progress.text()
        } else {
            String::new()
        };
        Self {
            name: name.to_owned(),
            judged,
            reason,
            punctuality: seen.punctuality,
        }
    }

    fn value(&self) -> Value {
        let mut value = Map::new();
        value.insert("object".into(), self.name.as_str().into());
        for Figure { key, value: of, .. } in &self.judged.figures {
            value.insert((*key).into(), of.clone());
        }
        value.insert("outcome".into(), self.judged.outcome.as_str().into());
        value.insert("as_expected".into(), self.judged.as_expected.into());
        value.insert("reason".into(), self.reason.as_str().into());
        if let Value::Object(punctuality) = self.punctuality.value() {
            value.extend(punctuality);
        }
        value.into()
    }

    /// Returns the outcome, with a short cause if the object was refused.
    fn outcome(&self) -> String {
        let outcome = &self.judged.outcome;
        match self.judged.cause {
            Some(cause) => format!("{outcome}: {}", no_break(&cause.name().replace('-', " "))),
            None => outcome.clone(),
        }
    }
}

pub(crate) fn print(task: &str, rows: &[Row], output: &mut Output) -> anyhow::Result<()> {
    let Some(first) = rows.first() else {
        return Ok(());
    };
    if output.is_json() {
        let as_expected = rows.iter().all(|row| row.judged.as_expected);
        let objects: Vec<Value> = rows.iter().map(Row::value).collect();
        return output.json(
            &serde_json::json!({ "task": task, "as_expected": as_expected, "objects": objects }),
        );
    }
    output.table(lines(first, rows, output))?;
    for row in rows.iter().filter(|row| !row.reason.is_empty()) {
        output.line(format_args!("{}: {}", row.name, row.reason))?;
    }
    match Punctuality::sum(rows.iter().map(|row| row.punctuality)).text() {
        Some(sentence) => output.line(sentence),
        None => Ok(()),
    }
}

/// Makes the table; reasons are printed below it because they are long.
fn lines(first: &Row, rows: &[Row], output: &Output) -> Table {
    let heads = first
        .judged
        .figures
        .iter()
        .filter_map(|figure| figure.heading);
    let header: Vec<&str> = ["object"]
        .into_iter()
        .chain(heads)
        .chain(["outcome"])
        .collect();
    let mut lines = table(&header);
    for row in rows {
        let figures = row.judged.figures.iter();
        let shown = figures.filter(|figure| figure.heading.is_some());
        let mut cells: Vec<Cell> = vec![row.name.as_str().into()];
        cells.extend(shown.map(|figure| figure.text.as_str().into()));
        cells.push(output.rated_cell(&row.outcome(), row.judged.as_expected.into()));
        lines.add_row(cells);
    }
    lines
}

pub(crate) fn verdict(rows: &[Row]) -> anyhow::Result<()> {
    let unexpected = rows.iter().filter(|row| !row.judged.as_expected);
    let sentences: Vec<String> = unexpected
        .map(|row| {
            format!(
                "{}: {}, expected {}",
                row.name, row.judged.outcome, row.judged.expected
            )
        })
        .collect();
    if sentences.is_empty() {
        return Ok(());
    }
    Err(ExitError::with_code(Exit::Unexpected, sentences.join("; ")))
}
