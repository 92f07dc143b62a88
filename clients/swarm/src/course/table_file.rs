//! Table file of a course: wheel levels row by row, and origin.

use std::path::Path;

use field::{ROWS, Responses, Wheels};
use serde::{Deserialize, Serialize};
use shm_schemas::layout::{FNV_OFFSET, fnv1a};

use super::fitness::Training;
use crate::error::{Error, Result};
use crate::evaluate::GoalPoints;
use crate::files::{is_of_kind, read_text, write_toml};

/// Value of `kind` in files of this type.
pub const KIND: &str = "course-table";
/// Name of the built-in table; `ebts evolve course --seed 3` reproduces it bit for bit.
pub const BUILT_IN: &str = "course";
const TEXT: &str = include_str!("../../tables/course.toml");

/// A table with its origin.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CourseFile {
    /// File type, [`KIND`].
    pub kind: String,
    /// Seed of the run.
    pub seed: u64,
    /// Generations of the run.
    pub generations: u32,
    /// Points per group of courses.
    pub points: GoalPoints,
    /// Per row the levels of the left and the right wheel, row 0 first. Row number: IR left 1 + IR
    /// front 2 + IR right 4 + photo left 8 + photo right 16.
    pub rows: String,
    /// Hash of the table.
    pub hash: String,
}

impl CourseFile {
    /// Creates the file of a table.
    #[must_use]
    pub fn new(table: Responses, (seed, generations): (u64, u32), points: GoalPoints) -> Self {
        let row = |row: u8| {
            let Wheels { left, right } = table.get(row);
            format!("{left}{right}")
        };
        Self {
            kind: KIND.to_owned(),
            seed,
            generations,
            points,
            rows: (0..ROWS as u8).map(row).collect::<Vec<_>>().join(" "),
            hash: hash(table),
        }
    }

    /// Returns whether a text is a file of this type.
    #[must_use]
    pub fn is_course_file(text: &str) -> bool {
        is_of_kind(text, KIND)
    }

    /// Returns whether a name is that of the built-in table or of a file of this type.
    #[must_use]
    pub fn is_course_name(name: &str) -> bool {
        name == BUILT_IN || read_text(Path::new(name)).is_ok_and(|text| Self::is_course_file(&text))
    }

    /// Writes the file atomically.
    pub fn write(&self, path: &Path) -> Result<()> {
        write_toml(path, self)
    }

    /// Returns the built-in table with this name, or that of a file.
    ///
    /// # Errors
    /// Neither exists, the rows are invalid, or the hash does not match.
    pub fn from_name(name: &str) -> Result<(Self, Responses)> {
        let path = Path::new(name);
        match name {
            BUILT_IN => Self::parse(TEXT, path),
            _ if path.exists() => Self::parse(&read_text(path)?, path),
            _ => Err(Error::refused(
                "choose a table",
                format_args!("{name:?} is neither the built-in table nor a file"),
                format_args!("{BUILT_IN} or a file of ebts evolve course"),
                "correct --table",
            )),
        }
    }

    /// Reads a file and evaluates its table again; returns also the rows that were read.
    ///
    /// # Errors
    /// See [`CourseFile::from_name`]; or the points do not match.
    pub fn read(path: &Path) -> Result<(Self, Responses, u32)> {
        let (file, table) = Self::parse(&read_text(path)?, path)?;
        let (points, rows_read) = Training::new(file.seed)?.evaluate(table);
        if points != file.points {
            let was = format!(
                "its table earns {points:?}, but the file has {:?}",
                file.points
            );
            return Err(refuse(path, &was));
        }
        Ok((file, table, rows_read))
    }

    /// Parses the text of a file; errors name its path.
    ///
    /// # Errors
    /// The rows are invalid, or the hash does not match.
    pub fn parse(text: &str, path: &Path) -> Result<(Self, Responses)> {
        let file: Self = toml::from_str(text).map_err(|error| refuse(path, &error.to_string()))?;
        let table = file.table().map_err(|was| refuse(path, &was))?;
        let named = file.kind == KIND && file.hash == hash(table);
        if !named {
            let was = format!("its hash does not match its rows, {}", hash(table));
            return Err(refuse(path, &was));
        }
        Ok((file, table))
    }

    /// Returns the fitness stored in the file.
    #[must_use]
    pub fn fitness(&self) -> f32 {
        self.points.iter().sum()
    }

    fn table(&self) -> core::result::Result<Responses, String> {
        let level = |digit: u8| matches!(digit, b'0'..=b'2').then(|| digit - b'0');
        let row = |text: &str| match text.as_bytes() {
            [left, right] => level(*left).zip(level(*right)),
            _ => None,
        };
        let mut rows = Vec::new();
        for text in self.rows.split_whitespace() {
            let (left, right) = row(text)
                .ok_or_else(|| format!("{text:?} is no row of two wheel levels from 0 to 2"))?;
            rows.push(Wheels { left, right });
        }
        if rows.len() != ROWS {
            return Err(format!(
                "it has {} rows, and five sensor bits make {ROWS}",
                rows.len()
            ));
        }
        Ok(Responses::from_fn(|row| rows[row]))
    }
}

fn hash(table: Responses) -> String {
    format!("{:016x}", fnv1a(FNV_OFFSET, &table.bits().to_le_bytes()))
}

fn refuse(path: &Path, was: &str) -> Error {
    Error::refused(
        format_args!("use {}", path.display()),
        was,
        "a table written by ebts evolve course",
        "evolve it again",
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn built_in_table_is_intact() {
        let (file, table) = CourseFile::from_name(BUILT_IN).expect("built-in table");
        assert_eq!(
            CourseFile::new(table, (file.seed, file.generations), file.points),
            file
        );
    }

    #[test]
    fn wrong_size_and_edited_tables_are_rejected() {
        let (file, _) = CourseFile::from_name(BUILT_IN).expect("built-in table");
        let check = |change: fn(&mut CourseFile), part: &str| {
            let mut changed = file.clone();
            change(&mut changed);
            let text = toml::to_string(&changed).expect("TOML");
            let error = CourseFile::parse(&text, Path::new("mine.toml")).expect_err("refused");
            let error = error.to_string();
            assert!(
                error.contains(part) && error.contains("mine.toml"),
                "{error}"
            );
        };
        check(|file| file.rows.truncate(47), "it has 16 rows");
        check(|file| file.rows.push_str(" 00"), "it has 33 rows");
        check(
            |file| file.rows.replace_range(..2, "03"),
            "\"03\" is no row",
        );
        check(|file| file.rows.replace_range(..2, "é"), "is no row");
        check(|file| file.hash = "0".repeat(16), "hash");
        check(|file| file.kind = "grasp-table".to_owned(), "hash");
        let error = CourseFile::from_name("nowhere.toml").expect_err("no such file");
        assert!(error.to_string().contains("neither"), "{error}");
    }
}
