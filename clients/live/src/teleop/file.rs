//! Target files: CSV with a header, or JSON lines with the same names. Errors are collected with
//! their line numbers.
//!
//! Fields `t_s,hand,x_m,y_m,z_m,yaw_rad,opening_m`: time since the start, `left` or `right`, centre
//! between the fingertips, direction of the closing axis, opening or the word `hold`.

use std::fmt::Write as _;
use std::path::Path;

use anyhow::Context;
use atas_client::TeleopTarget;
use atas_console::{Exit, ExitError};
use serde_json::Value;
use shm_schemas::Hand;

const FIELDS: [&str; 7] = ["t_s", "hand", "x_m", "y_m", "z_m", "yaw_rad", "opening_m"];
/// Opening value that leaves the grip to tactile control.
const HOLD: &str = "hold";
/// Most errors printed (design choice: one screen).
const ERRORS_MAX: usize = 20;
/// Longest file, s: one hour, the limit of every goal.
const DURATION_MAX_S: f64 = 3600.0;

/// Target with its start time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct TimedTarget {
    /// Time since the start, s.
    pub(super) t_s: f64,
    pub(super) wanted: TeleopTarget,
}

/// Largest target file, bytes. Design choice: an hour at 200 Hz.
const BYTES_MAX: u64 = 256 << 20;

pub(super) fn read(path: &Path) -> anyhow::Result<Vec<TimedTarget>> {
    let text = atas_text_file::read_at_most(path, BYTES_MAX)
        .with_context(|| format!("could not read {}", path.display()))?;
    parse(&text).map_err(|findings| {
        let mut sentence = format!("invalid target file {}:", path.display());
        for finding in findings.iter().take(ERRORS_MAX) {
            // Writing to a string cannot fail.
            let _written = write!(sentence, "\n  {finding}");
        }
        if findings.len() > ERRORS_MAX {
            let _written = write!(sentence, "\n  and {} more", findings.len() - ERRORS_MAX);
        }
        ExitError::with_code(Exit::Usage, sentence)
    })
}

/// Returns the targets, or all errors.
pub(super) fn parse(text: &str) -> Result<Vec<TimedTarget>, Vec<String>> {
    let lines = || {
        text.lines()
            .enumerate()
            .map(|(at, line)| (at + 1, line.trim()))
    };
    let mut rows = lines().filter(|(_, line)| !line.is_empty() && !line.starts_with('#'));
    let first = rows.clone().next().map_or("", |(_, line)| line);
    let is_json = first.starts_with('{');
    let columns = if is_json {
        Vec::new()
    } else {
        header(&mut rows)?
    };
    let (mut targets, mut findings, mut last_s) = (Vec::new(), Vec::new(), 0.0);
    for (at, line) in rows {
        let fields = if is_json {
            json(line)
        } else {
            csv(line, &columns)
        };
        match fields.and_then(|fields| parse_row(&fields, last_s)) {
            Ok(target) => {
                last_s = target.t_s;
                targets.push(target);
            }
            Err(wrong) => findings.extend(wrong.iter().map(|wrong| format!("line {at}: {wrong}"))),
        }
    }
    if targets.is_empty() && findings.is_empty() {
        findings.push("no targets, needs at least one".to_owned());
    }
    if findings.is_empty() {
        Ok(targets)
    } else {
        Err(findings)
    }
}

/// Fields of one row, in the order of [`FIELDS`].
type Row = [String; FIELDS.len()];

/// Returns the column of each field.
fn header<'a>(
    rows: &mut impl Iterator<Item = (usize, &'a str)>,
) -> Result<Vec<usize>, Vec<String>> {
    let (at, line) = rows.next().unwrap_or((1, ""));
    let names: Vec<&str> = line.split(',').map(str::trim).collect();
    let place = |field: &&str| {
        let column = names.iter().position(|name| name == field);
        column.ok_or(format!(
            "line {at}: has no column {field}, needs {}",
            FIELDS.join(",")
        ))
    };
    let places: Vec<Result<usize, String>> = FIELDS.iter().map(place).collect();
    let missing: Vec<String> = places
        .iter()
        .filter_map(|place| place.clone().err())
        .collect();
    if missing.is_empty() {
        Ok(places.into_iter().flatten().collect())
    } else {
        Err(missing)
    }
}

fn csv(line: &str, columns: &[usize]) -> Result<Row, Vec<String>> {
    let values: Vec<&str> = line.split(',').map(str::trim).collect();
    let mut row = Row::default();
    let mut missing = Vec::new();
    for ((slot, column), field) in row.iter_mut().zip(columns).zip(FIELDS) {
        match values.get(*column).filter(|value| !value.is_empty()) {
            Some(value) => (*slot) = (*value).to_owned(),
            None => missing.push(format!("has no {field}")),
        }
    }
    if missing.is_empty() {
        Ok(row)
    } else {
        Err(missing)
    }
}

fn json(line: &str) -> Result<Row, Vec<String>> {
    let value: Value =
        serde_json::from_str(line).map_err(|error| vec![format!("is not valid JSON: {error}")])?;
    let mut row = Row::default();
    let mut wrong = Vec::new();
    for (slot, field) in row.iter_mut().zip(FIELDS) {
        match &value[field] {
            Value::String(text) => slot.clone_from(text),
            Value::Number(number) => *slot = number.to_string(),
            _ => wrong.push(format!("has no {field}")),
        }
    }
    if wrong.is_empty() {
        Ok(row)
    } else {
        Err(wrong)
    }
}

/// Returns the target of a row, or all its errors.
fn parse_row(row: &Row, last_s: f64) -> Result<TimedTarget, Vec<String>> {
    let mut wrong = Vec::new();
    let mut number = |index: usize| {
        let value = row[index]
            .parse()
            .ok()
            .filter(|value: &f64| value.is_finite());
        if value.is_none() {
            wrong.push(format!(
                "{} is {:?}, needs a finite number",
                FIELDS[index], row[index]
            ));
        }
        value.unwrap_or(0.0)
    };
    let (t_s, centre_m, yaw_rad) = (number(0), [number(2), number(3), number(4)], number(5));
    let opening_m = (row[6] != HOLD).then(|| number(6));
    if !(last_s..=DURATION_MAX_S).contains(&t_s) {
        wrong.push(format!(
            "t_s is {t_s}, needs {last_s} to {DURATION_MAX_S}: times must not decrease"
        ));
    }
    let hand = Hand::from_name(&row[1]);
    if hand.is_none() {
        wrong.push(format!("hand is {:?}, needs left or right", row[1]));
    }
    match hand.filter(|_| wrong.is_empty()) {
        Some(hand) => Ok(TimedTarget {
            t_s,
            wanted: TeleopTarget {
                hand,
                centre_m,
                yaw_rad,
                opening_m,
            },
        }),
        None => Err(wrong),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn csv_and_json_give_equal_targets() {
        let csv = "# to the right\nt_s,hand,x_m,y_m,z_m,yaw_rad,opening_m\n0,right,0.3,-0.2,0.1,1.57,0.06\n\n1.5,left,0.3,0.2,0.1,0,hold\n";
        let json = concat!(
            "{\"t_s\":0,\"hand\":\"right\",\"x_m\":0.3,\"y_m\":-0.2,\"z_m\":0.1,\"yaw_rad\":1.57,\"opening_m\":0.06}\n",
            "{\"t_s\":1.5,\"hand\":\"left\",\"x_m\":0.3,\"y_m\":0.2,\"z_m\":0.1,\"yaw_rad\":0,\"opening_m\":\"hold\"}\n"
        );
        let targets = parse(csv).expect("valid CSV");
        assert_eq!(parse(json).expect("valid JSON"), targets);
        assert_eq!(targets[0].wanted.opening_m, Some(0.06));
        assert_eq!((targets[1].t_s, targets[1].wanted.opening_m), (1.5, None));
        assert_eq!(targets[1].wanted.hand, Hand::LEFT);
    }

    #[test]
    fn all_errors_are_listed_with_line_numbers() {
        let check = |text: &str, expected: &[&str]| assert_eq!(parse(text).unwrap_err(), expected);
        let head = "t_s,hand,x_m,y_m,z_m,yaw_rad,opening_m";
        check(head, &["no targets, needs at least one"]);
        check(
            "t_s,hand,x_m,y_m,z_m,yaw_rad\n0,right,1,1,1,1",
            &["line 1: has no column opening_m, needs t_s,hand,x_m,y_m,z_m,yaw_rad,opening_m"],
        );
        check(
            &format!("{head}\n1,middle,nan,x,1,1,hold\n1,right,1,1\n0.5,left,1,1,1,inf,tight"),
            &[
                "line 2: x_m is \"nan\", needs a finite number",
                "line 2: y_m is \"x\", needs a finite number",
                "line 2: hand is \"middle\", needs left or right",
                "line 3: has no z_m",
                "line 3: has no yaw_rad",
                "line 3: has no opening_m",
                "line 4: yaw_rad is \"inf\", needs a finite number",
                "line 4: opening_m is \"tight\", needs a finite number",
            ],
        );
        check(
            &format!("{head}\n1,left,1,1,1,1,1\n0.5,left,1,1,1,1,1\n-1,left,1,1,1,1,1"),
            &[
                "line 3: t_s is 0.5, needs 1 to 3600: times must not decrease",
                "line 4: t_s is -1, needs 1 to 3600: times must not decrease",
            ],
        );
        let [no_json, no_time] = ["{\"t_s\":0,", "{\"hand\":\"left\"}"];
        let wrong = parse(&format!("{no_json}\n{no_time}")).unwrap_err();
        assert!(
            wrong[0].starts_with("line 1: is not valid JSON: "),
            "{wrong:?}"
        );
        assert_eq!(wrong[1], "line 2: has no t_s");
    }
}
