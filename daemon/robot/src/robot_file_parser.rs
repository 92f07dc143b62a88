//! Parser of robot files: reports all errors of the TOML.
//!
//! A parser of typed TOML stops at its first error. This module removes or replaces the part with
//! the error and parses again, until no error is left.

use std::fmt;
use std::ops::Range;
use std::string::{String, ToString};
use std::vec::Vec;

use serde::Deserialize;
use toml::Spanned;
use toml::de::{DeTable, DeValue, Deserializer};

use crate::robot_file::RobotFile;

/// Required keys, each with a valid value. A missing or invalid one is replaced by it.
const REQUIRED: &str = r#"
hands = {}
palm = ""
down = [0.0, 0.0, 0.0]
fingers = []
tip = ""
side = 1
layout = ""
compression_m = 0.0
exponent = 1.0
stiffness = 0.0
inertia = 0.0
x_m = [0.0, 0.0]
y_m = [0.0, 0.0]
z_m = [0.0, 0.0]
opening_m = [0.0, 0.0]
"#;
/// Largest number of reported errors. Design choice: more would not fit on a screen.
const ERRORS_MAX: usize = 32;

/// Error in a robot file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RobotFileError {
    /// Line, counted from 1.
    pub line: usize,
    /// Description.
    pub message: String,
}

/// Errors of a robot file, by line.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RobotFileErrors(pub Vec<RobotFileError>);

impl std::error::Error for RobotFileErrors {}

impl fmt::Display for RobotFileErrors {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (index, RobotFileError { line, message }) in self.0.iter().enumerate() {
            let separator = if index == 0 { "" } else { "\n" };
            write!(
                f,
                "{separator}could not load the robot because line {line} of the robot file was \
                 invalid ({message}); correct it there"
            )?;
        }
        Ok(())
    }
}

impl RobotFile {
    /// Parses the text of a robot file.
    ///
    /// # Errors
    /// All errors, by line.
    ///
    /// ```
    /// use robot_model::RobotFile;
    ///
    /// let text = "[hands.right]\npalm = 7\ndown = [0, 0, -1]\nfinger = []\n";
    /// let errors = RobotFile::parse(text).expect_err("three errors");
    /// let lines: Vec<usize> = errors.0.iter().map(|error| error.line).collect();
    /// assert_eq!(lines, [1, 2, 4], "missing key, wrong type, unknown key");
    /// ```
    pub fn parse(text: &str) -> Result<Self, RobotFileErrors> {
        let error = |error: &toml::de::Error| RobotFileError {
            line: line(text, error.span().map_or(0, |span| span.start)),
            message: error.message().replace('\n', ", "),
        };
        let root = DeTable::parse(text);
        let mut root = root.map_err(|first| RobotFileErrors(std::vec![error(&first)]))?;
        let mut errors = Vec::new();
        while errors.len() < ERRORS_MAX {
            let found = match Self::deserialize(Deserializer::from(root.clone())) {
                Ok(file) if errors.is_empty() => return Ok(file),
                Ok(_) => break,
                Err(found) => found,
            };
            errors.push(error(&found));
            let Some(span) = found.span() else { break };
            if !repair(&mut root, &span, Fault::from_message(found.message())) {
                break;
            }
        }
        errors.sort_by_key(|error| error.line);
        Err(RobotFileErrors(errors))
    }
}

fn line(text: &str, offset: usize) -> usize {
    text.bytes().take(offset).filter(|b| *b == b'\n').count() + 1
}

/// Kind of an error, which decides the repair.
#[derive(Clone, Copy)]
enum Fault<'a> {
    /// A required key is missing in the table.
    Missing(&'a str),
    /// The key is unknown.
    Unknown,
    /// The value is invalid.
    Invalid,
}

impl<'a> Fault<'a> {
    fn from_message(message: &'a str) -> Self {
        let missing = message.strip_prefix("missing field `");
        match missing.and_then(|rest| rest.split('`').next()) {
            Some(key) => Self::Missing(key),
            None if message.starts_with("unknown field") => Self::Unknown,
            None => Self::Invalid,
        }
    }
}

/// Repairs the part with this span. Returns false if there is none.
fn repair(root: &mut Spanned<DeTable<'_>>, span: &Range<usize>, fault: Fault<'_>) -> bool {
    match fault {
        Fault::Missing(key) if root.span() == *span => insert(root.get_mut(), key),
        _ => repair_table(root.get_mut(), span, fault),
    }
}

fn repair_table(table: &mut DeTable<'_>, span: &Range<usize>, fault: Fault<'_>) -> bool {
    let mut entries = table.iter();
    let found = entries.find(|(key, value)| key.span() == *span || value.span() == *span);
    if let Some(name) = found.map(|(key, _)| key.get_ref().to_string()) {
        let value = table.get_mut(name.as_str()).map(Spanned::get_mut);
        return match (fault, value) {
            (Fault::Missing(key), Some(DeValue::Table(inner))) => insert(inner, key),
            (Fault::Missing(_), _) => false,
            (Fault::Unknown, _) => table.remove(name.as_str()).is_some(),
            (Fault::Invalid, _) => {
                table.remove(name.as_str());
                // An optional key stays removed.
                let _ = insert(table, &name);
                true
            }
        };
    }
    let mut values = table.iter_mut().map(|(_, value)| value.get_mut());
    values.any(|value| repair_value(value, span, fault))
}

fn repair_value(value: &mut DeValue<'_>, span: &Range<usize>, fault: Fault<'_>) -> bool {
    match value {
        DeValue::Table(table) => repair_table(table, span, fault),
        DeValue::Array(items) => items.iter_mut().any(|item| {
            let is_item = item.span() == *span;
            match (fault, item.get_mut()) {
                (Fault::Missing(key), DeValue::Table(table)) if is_item => insert(table, key),
                (_, item) => repair_value(item, span, fault),
            }
        }),
        _ => false,
    }
}

/// Inserts the valid value of a required key. Returns false for another key, or a present one.
fn insert(table: &mut DeTable<'_>, key: &str) -> bool {
    let Ok(required) = DeTable::parse(REQUIRED) else {
        return false;
    };
    let mut entries = required.into_inner().into_iter();
    let found = entries.find(|(name, _)| name.get_ref() == key);
    found.is_some_and(|(name, value)| table.insert(name, value).is_none())
}
