//! Converts a recorded run to a table with the tactile frames during labelled time spans.
//!
//! The label table has the columns `from_s,to_s` and the labels. Optional columns `hand` and
//! `finger` restrict a row to one fingertip. Each span of each fingertip is a case. Times count
//! from the run's first tick.

use std::path::Path;

use anyhow::{Context, bail, ensure};
use atas_recording::{Frames, RecordedFrame, is_recording};
use shm_schemas::Hand;
use shm_schemas::capacity::FINGERS;

use super::cases::Labels;
use super::sheet::Sheet;

/// Columns that define time and place of a label; all others are labels.
const SPAN_COLUMNS: [&str; 4] = ["from_s", "to_s", "hand", "finger"];

/// Opens a run or a table; returns the table and the labels to use with it.
///
/// # Errors
/// A file cannot be read, a run has no label table, or no frame of the run lies in its spans.
pub fn open(path: &Path, labels: &Labels) -> anyhow::Result<(Sheet, Labels)> {
    if !is_recording(path)? {
        return Ok((Sheet::open(path)?, labels.clone()));
    }
    let file = labels
        .file
        .clone()
        .unwrap_or_else(|| path.with_extension("csv"));
    let table = Sheet::open(&file).with_context(|| {
        format!(
            "could not evaluate the run {}: it needs a table of labels with columns from_s,to_s \
             and a label, optionally hand,finger; name it with --labels-file",
            path.display()
        )
    })?;
    let labels = Labels {
        file: None,
        ..labels.clone()
    };
    Ok((sheet(path, &table)?, labels))
}

struct Span {
    from_s: f64,
    to_s: f64,
    hand: Option<Hand>,
    finger: Option<usize>,
}

struct FingertipReading {
    span: usize,
    hand: Hand,
    finger: usize,
    at_s: f64,
    /// Force per element; `None` for an invalid element.
    forces_n: Vec<Option<[f32; 3]>>,
}

fn sheet(path: &Path, table: &Sheet) -> anyhow::Result<Sheet> {
    let spans = spans(table)?;
    let mut touches = Vec::new();
    for measured in Frames::open(&[path.to_owned()]) {
        append_readings(&measured?, &spans, &mut touches);
    }
    ensure!(
        !touches.is_empty(),
        "could not evaluate {}: none of its frames lies within the {} spans of {}; spans are in \
         seconds from the first tick",
        path.display(),
        spans.len(),
        table.path.display()
    );
    let elements = touches.iter().map(|touch| touch.forces_n.len()).max();
    let elements = elements.unwrap_or(0);
    ensure!(
        elements > 1 || is_one_fingertip(&touches),
        "could not evaluate contacts of several fingertips in {}; select one with the columns hand \
         and finger of {}",
        path.display(),
        table.path.display()
    );
    let truths: Vec<usize> = (0..table.columns().len())
        .filter(|&column| !SPAN_COLUMNS.contains(&&*table.columns()[column]))
        .collect();
    let rows = touches
        .iter()
        .map(|touch| row(touch, elements, table, &truths));
    let names = truths.iter().map(|&column| table.columns()[column].clone());
    let header = ["sequence".to_owned(), "t_s".to_owned()].into_iter();
    let header = header.chain(names).chain(element_columns(elements));
    Ok(Sheet::from_rows(path, header.collect(), rows.collect()))
}

fn append_readings(measured: &RecordedFrame, spans: &[Span], touches: &mut Vec<FingertipReading>) {
    if !measured.frame.is_intact() {
        return;
    }
    let captured_ns = measured.frame.stamp.captured_ns;
    let at_s = (captured_ns as i128 - i128::from(measured.begun_ns)) as f64 * 1e-9;
    let fingers = (measured.frame.finger_count as usize).min(FINGERS);
    for (number, span) in spans.iter().enumerate() {
        if !span.contains(at_s, measured.hand) {
            continue;
        }
        for finger in (0..fingers).filter(|finger| span.finger.is_none_or(|only| only == *finger)) {
            let mask = measured.frame.valid_mask[finger];
            let count = (u64::BITS - mask.leading_zeros()) as usize;
            let force_n = |element: usize| {
                let is_valid = mask >> element & 1 == 1;
                is_valid.then(|| measured.frame.force_n[finger][element])
            };
            touches.push(FingertipReading {
                span: number,
                hand: measured.hand,
                finger,
                at_s,
                forces_n: (0..count).map(force_n).collect(),
            });
        }
    }
}

impl Span {
    fn contains(&self, at_s: f64, hand: Hand) -> bool {
        (self.from_s..self.to_s).contains(&at_s) && self.hand.is_none_or(|only| only == hand)
    }
}

fn spans(table: &Sheet) -> anyhow::Result<Vec<Span>> {
    let name = table.path.display();
    let [from_s, to_s, hand, finger] = SPAN_COLUMNS.map(|column| table.column(column));
    let (Some(from_s), Some(to_s)) = (from_s, to_s) else {
        bail!(
            "could not read labels of a run from {name}: it has the columns {:?}, but from_s, to_s \
             and a label are needed",
            table.columns()
        );
    };
    let cell = |row: usize, column: Option<usize>| {
        let text = column.map_or("", |column| table.text(row, column));
        (!text.is_empty()).then_some(text)
    };
    let span = |row: usize| {
        let (from_s, to_s) = (table.number(row, from_s)?, table.number(row, to_s)?);
        let hand = cell(row, hand).map(Hand::from_name);
        let finger = cell(row, finger).map(|text| text.parse().ok().filter(|n| *n < FINGERS));
        let span = Span {
            from_s,
            to_s,
            hand: hand.map_or(Some(None), |known| known.map(Some))?,
            finger: finger.map_or(Some(None), |known| known.map(Some))?,
        };
        (from_s < to_s).then_some(span)
    };
    (0..table.len())
        .map(|row| {
            span(row).with_context(|| {
                format!(
                    "could not use row {} of {name}: it needs from_s below to_s, hand left, right \
                     or empty, and finger 0 to {} or empty",
                    row + 1,
                    FINGERS - 1
                )
            })
        })
        .collect()
}

fn is_one_fingertip(touches: &[FingertipReading]) -> bool {
    let place = |touch: &FingertipReading| (touch.hand, touch.finger);
    touches
        .iter()
        .all(|touch| place(touch) == place(&touches[0]))
}

fn row(
    touch: &FingertipReading,
    elements: usize,
    table: &Sheet,
    truths: &[usize],
) -> csv::StringRecord {
    let FingertipReading {
        span,
        hand,
        finger,
        at_s,
        forces_n,
    } = touch;
    let mut row = csv::StringRecord::new();
    row.push_field(&format!("{} {hand} {finger}", span + 1));
    row.push_field(&at_s.to_string());
    for &column in truths {
        row.push_field(table.text(*span, column));
    }
    for element in 0..elements {
        let force_n = forces_n.get(element).copied().flatten();
        for axis in 0..3 {
            row.push_field(&force_n.map_or_else(String::new, |force_n| force_n[axis].to_string()));
        }
    }
    row
}

fn element_columns(elements: usize) -> impl Iterator<Item = String> {
    (0..elements).flat_map(move |element| {
        let number = if elements == 1 {
            String::new()
        } else {
            element.to_string()
        };
        ["normal", "tangential1", "tangential2"].map(|axis| format!("{axis}{number}_n"))
    })
}
