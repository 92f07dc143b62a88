//! Groups rows into cases with their object and label.

use std::collections::BTreeMap;
use std::path::PathBuf;

use anyhow::{Context, bail, ensure};

use super::kind::Kind;
use super::sheet::Sheet;

/// Source and meaning of the labels.
#[derive(Clone, Debug, Default)]
pub struct Labels {
    /// Label column.
    pub column: Option<String>,
    /// File with the label column, if the recording lacks it. Default: another .csv in the same
    /// folder.
    pub file: Option<PathBuf>,
    /// Values that mean slip or hard; if empty, all but the negative ones.
    pub positive: Vec<String>,
    /// Values that mean stable or soft; if empty, the model's.
    pub negative: Vec<String>,
    /// Column that identifies the object.
    pub objects: Option<String>,
}

#[derive(Clone, Debug, PartialEq)]
pub(super) struct Case {
    pub(super) rows: Vec<usize>,
    /// Object in contact. Cases of one object are never split between fitting and evaluation.
    pub(super) object: String,
    /// Category of the object, if a recording has several (column `fruit` or `sort`).
    pub(super) category: String,
    pub(super) label: String,
}

/// Returns the columns that may number the cases, in order of preference.
fn keys(kind: &Kind) -> &'static [&'static str] {
    match kind {
        Kind::Slip { .. } => &["sequence", "sample", "trial"],
        Kind::Squeeze { .. } => &["sample", "sequence", "trial"],
        Kind::Press { .. } => &["trial", "sample", "sequence"],
        Kind::Touch { .. } => &[],
    }
}

pub(super) fn cases(sheet: &Sheet, kind: &Kind, labels: &Labels) -> anyhow::Result<Vec<Case>> {
    let key = sheet.first_of(keys(kind));
    let sort = sheet.first_of(&["fruit", "sort"]);
    let object = match &labels.objects {
        Some(name) => Some(sheet.column(name).with_context(|| {
            format!(
                "could not find the column {name:?} of objects in {}",
                sheet.path.display()
            )
        })?),
        None => sheet.first_of(&["object"]).or(key),
    };
    let truth = label_source(sheet, key, labels)?;
    let mut found: Vec<Case> = Vec::new();
    let mut places: BTreeMap<(String, String), usize> = BTreeMap::new();
    let (mut run, mut before) = (0, None);
    for row in 0..sheet.len() {
        let cell = |column: Option<usize>| column.map_or("", |column| sheet.text(row, column));
        let label = truth.label(sheet, row, cell(key));
        // Without a case number, a case ends where label or object changes.
        let now = Some((cell(object), label.clone()));
        if key.is_none() && before.is_some() && before != now {
            run += 1;
        }
        before = now;
        let number = key.map_or_else(|| run.to_string(), |_| cell(key).to_owned());
        let identity = (cell(sort).to_owned(), number);
        let place = *places.entry(identity).or_insert_with(|| {
            found.push(Case {
                rows: Vec::new(),
                object: cell(object).to_owned(),
                category: cell(sort).to_owned(),
                label: label.clone(),
            });
            found.len() - 1
        });
        // A row without a label takes the label of its case.
        if found[place].label.is_empty() {
            found[place].label.clone_from(&label);
        }
        ensure!(
            label.is_empty() || found[place].label == label,
            "could not evaluate {}: the rows of {} {:?} have the labels {:?} and {label:?}; use \
             one label per case, or remove this column",
            sheet.path.display(),
            key.map_or("case", |key| sheet.columns()[key].as_str()),
            cell(key),
            found[place].label
        );
        found[place].rows.push(row);
    }
    Ok(found)
}

enum Truth {
    Column(usize),
    /// Another table: label by case number.
    Table(BTreeMap<String, String>),
    None,
}

impl Truth {
    fn label(&self, sheet: &Sheet, row: usize, key: &str) -> String {
        match self {
            Self::Column(column) => sheet.text(row, *column).to_owned(),
            Self::Table(table) => table.get(key).cloned().unwrap_or_default(),
            Self::None => String::new(),
        }
    }
}

fn label_source(sheet: &Sheet, key: Option<usize>, labels: &Labels) -> anyhow::Result<Truth> {
    let Some(column) = &labels.column else {
        return Ok(Truth::None);
    };
    if let (Some(own), None) = (sheet.column(column), &labels.file) {
        return Ok(Truth::Column(own));
    }
    let recording = sheet.path.display();
    let Some(key) = key.map(|key| sheet.columns()[key].as_str()) else {
        bail!(
            "could not find the column {column:?} in {recording}; it has {:?}",
            sheet.columns()
        );
    };
    let beside = match &labels.file {
        Some(file) => Sheet::open(file)?,
        None => find_label_table(sheet, column, key)?,
    };
    let place = beside.path.display();
    let of = |name: &str| {
        beside.column(name).with_context(|| {
            format!(
                "could not read labels from {place}: it has no column {name:?}; it needs the \
                columns {key:?} and {column:?}"
            )
        })
    };
    let (key, value) = (of(key)?, of(column)?);
    let pairs = (0..beside.len()).map(|row| {
        (
            beside.text(row, key).to_owned(),
            beside.text(row, value).to_owned(),
        )
    });
    Ok(Truth::Table(pairs.collect()))
}

/// Opens the only other table in the recording's folder with label and key column.
fn find_label_table(sheet: &Sheet, column: &str, key: &str) -> anyhow::Result<Sheet> {
    let folder = match sheet.path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => std::path::Path::new("."),
    };
    let mut found = Vec::new();
    let mut paths: Vec<PathBuf> = std::fs::read_dir(folder)
        .with_context(|| format!("could not look for labels in {}", folder.display()))?
        .filter_map(|entry| Some(entry.ok()?.path()))
        .filter(|path| path.extension().is_some_and(|end| end == "csv") && *path != sheet.path)
        .collect();
    paths.sort();
    for path in paths {
        if let Ok(table) = Sheet::open(&path)
            && table.column(column).is_some()
            && table.column(key).is_some()
        {
            found.push(table);
        }
    }
    match found.len() {
        1 => Ok(found.remove(0)),
        0 => bail!(
            "could not find the column {column:?}: neither {} nor another .csv in its folder with \
             a column {key:?} has it; name the file with --labels-file",
            sheet.path.display()
        ),
        _ => bail!(
            "could not choose between {} and {} for the column {column:?}; name one with --labels-file",
            found[0].path.display(),
            found[1].path.display()
        ),
    }
}
