//! Table files: human-readable, editable TOML with an integrity hash.
//!
//! A file contains all inputs of its fitness (rows, sensor order, preset, scoring) and its origin.
//! Its last line is a SHA-256 over all of that, so truncated, damaged or edited files are rejected.
//! After a manual edit, `ebts show FILE --rehash` evaluates the table, updates its points, marks it
//! as edited and writes a new hash. Comments and row order are free.

use std::fmt::Write as _;
use std::path::Path;

use serde::{Deserialize, Serialize};

use crate::condition::{Condition, Setup};
use crate::error::{Error, Result};
use crate::evaluate::{Evaluator, GoalPoints, Individual};
use crate::files::{read_text, sha256, write_atomically};
use crate::genome::Genome;
use crate::run::Record;
use crate::table::{Shape, Table, behaviour};

const FORMAT: &str = "ebts-table-1";

/// The tables of one team with their provenance.
#[derive(Clone, Debug)]
pub struct TableFile {
    /// Inputs of the fitness.
    pub condition: Condition,
    /// Run that evolved the table; `None` for a table made by hand.
    pub origin: Option<Origin>,
    /// True if rows were edited by hand.
    pub edited: bool,
    /// Version of this crate that evaluated the table.
    pub code_version: String,
    /// Rows and their points.
    pub individual: Individual,
}

/// Origin of an evolved table.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Origin {
    /// Seed of the run.
    pub seed: u64,
    /// Number of generations.
    pub generations: u32,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Content {
    format: String,
    code_version: String,
    edited: bool,
    points: GoalPoints,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    origin: Option<Origin>,
    condition: Setup,
    table: Vec<Rows>,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Rows {
    rows: Vec<String>,
}

#[derive(Deserialize)]
struct HashedContent {
    #[serde(flatten)]
    content: toml::Table,
    integrity: Option<Integrity>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Integrity {
    sha256: String,
}

impl TableFile {
    /// Returns the best table of a finished run.
    pub fn from_record(condition: &Condition, record: &Record, generations: u32) -> Result<Self> {
        let genome =
            Genome::from_hex(condition.genome_bits(), &record.genome).ok_or_else(|| {
                let bits = condition.genome_bits();
                Error::refused(
                    "use a run's genome",
                    "its digits are not a genome",
                    format_args!("{bits} bits"),
                    "run it again",
                )
            })?;
        Ok(Self {
            condition: condition.clone(),
            origin: Some(Origin {
                seed: record.seed,
                generations,
            }),
            edited: false,
            code_version: env!("CARGO_PKG_VERSION").to_owned(),
            individual: Individual {
                genome,
                points: record.points,
            },
        })
    }

    /// Returns the points per goal in the preset's eight trials. They differ from the stored ones
    /// if evolution drew its trials.
    #[must_use]
    pub fn points_on_field(&self) -> GoalPoints {
        let Self {
            condition,
            individual,
            ..
        } = self;
        match condition.training() {
            None => individual.points,
            Some(_) => {
                Evaluator::points_on(condition, vec![condition.layouts()], &individual.genome)
            }
        }
    }

    /// Reads a file and validates it, including its hash.
    pub fn read(path: &Path) -> Result<Self> {
        Self::parse(&read_text(path)?, Hash::Required).map_err(|why| refuse(path, &why))
    }

    /// Reads a file edited by hand: validates everything except the hash.
    pub fn read_edited(path: &Path) -> Result<Self> {
        Self::parse(&read_text(path)?, Hash::Ignored).map_err(|why| refuse(path, &why))
    }

    /// Parses the text of a file.
    pub fn parse(text: &str, hash: Hash) -> std::result::Result<Self, String> {
        let sealed: HashedContent = toml::from_str(text)
            .map_err(|error| format!("it is not a table file: {}", error.message()))?;
        let content: Content =
            toml::Value::Table(sealed.content)
                .try_into()
                .map_err(|error: toml::de::Error| {
                    format!("it is not a table file: {}", error.message())
                })?;
        let file = content.check()?;
        if let Hash::Required = hash {
            let found = sealed
                .integrity
                .ok_or("integrity.sha256 is missing (the file may be truncated), needs the hash")?
                .sha256;
            if found != file.hash() {
                return Err(format!(
                    "integrity.sha256 is {found}, needs {} for this content",
                    file.hash()
                ));
            }
        }
        Ok(file)
    }

    /// Writes the file atomically.
    pub fn write(&self, path: &Path) -> Result<()> {
        write_atomically(path, self.to_text().as_bytes())
    }

    /// Returns the hash of the content without comments and layout.
    #[must_use]
    pub fn hash(&self) -> String {
        // Strings, numbers and enums always serialise to JSON; fields keep the order of
        // declaration.
        sha256(
            serde_json::to_string(&self.content())
                .unwrap_or_default()
                .as_bytes(),
        )
    }

    /// Returns the text of the file.
    #[must_use]
    pub fn to_text(&self) -> String {
        let content = self.content();
        let mut text = format!(
            "# Behaviour table of an EBTS team. To change what the agents do, edit rows, then run: ebts show FILE --rehash\n\
             format = {}\ncode_version = {}\nedited = {}\npoints = {:?} # per goal; fitness {}\n",
            quoted(&content.format),
            quoted(&content.code_version),
            content.edited,
            content.points,
            self.individual.fitness(),
        );
        if let Some(Origin { seed, generations }) = content.origin {
            let _ = write!(
                text,
                "\n[origin]\nseed = {seed}\ngenerations = {generations}\n"
            );
        }
        let Setup {
            agents,
            sharing,
            sensors,
            fitness_rule,
            preset,
        } = &content.condition;
        let _ = write!(text, "\n[condition]\nagents = {agents}\n");
        for (key, value) in [
            ("sharing", value(sharing)),
            ("sensors", value(sensors)),
            ("fitness_rule", value(fitness_rule)),
        ] {
            let _ = writeln!(text, "{key} = {value}");
        }
        let _ = write!(text, "\n[condition.preset]\n{}", entries(preset));
        for (rows, table) in content
            .table
            .iter()
            .zip(self.condition.tables_of(&self.individual.genome))
        {
            text.push_str("\n[[table]]\n# S1-S5 L1L2 R1R2\nrows = [\n");
            for (row_text, row) in rows.rows.iter().zip(paper_order(table.shape())) {
                let words = behaviour(table.level(row, 0), table.level(row, 1));
                let _ = writeln!(text, "    {}, # {words}", quoted(row_text));
            }
            text.push_str("]\n");
        }
        let _ = write!(text, "\n[integrity]\nsha256 = {}\n", quoted(&self.hash()));
        text
    }

    fn content(&self) -> Content {
        let rows = |table: Table| Rows {
            rows: paper_order(table.shape())
                .map(|row| row_text(&table, row))
                .collect(),
        };
        Content {
            format: FORMAT.to_owned(),
            code_version: self.code_version.clone(),
            edited: self.edited,
            points: self.individual.points,
            origin: self.origin,
            condition: Setup::from(&self.condition),
            table: self
                .condition
                .tables_of(&self.individual.genome)
                .into_iter()
                .map(rows)
                .collect(),
        }
    }
}

/// Treatment of the hash of a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Hash {
    /// The hash must match.
    Required,
    /// The file was edited by hand and receives a new hash.
    Ignored,
}

impl Content {
    fn check(self) -> std::result::Result<TableFile, String> {
        if self.format != FORMAT {
            return Err(format!("format is {:?}, needs {FORMAT:?}", self.format));
        }
        if let Some(points) = self
            .points
            .iter()
            .find(|points| !(0.0..=100.0).contains(*points))
        {
            return Err(format!("points has {points}, needs 0 to 100 per goal"));
        }
        let condition = self.condition.build().map_err(|error| error.to_string())?;
        if self.table.len() != condition.tables() {
            return Err(format!(
                "it has {} [[table]], needs {}",
                self.table.len(),
                condition.tables()
            ));
        }
        let mut genome = Genome::zero(condition.genome_bits());
        for (index, table) in self.table.iter().enumerate() {
            read_rows(
                &table.rows,
                Shape::MOBILE_ROBOT,
                &mut genome,
                index * Shape::MOBILE_ROBOT.genome_bits(),
            )?;
        }
        Ok(TableFile {
            condition,
            origin: self.origin,
            edited: self.edited,
            code_version: self.code_version,
            individual: Individual {
                genome,
                points: self.points,
            },
        })
    }
}

/// Returns the rows in the order of the paper's Table 1: S1 is the most significant bit.
fn paper_order(shape: Shape) -> impl Iterator<Item = usize> {
    (0..shape.rows()).map(move |number| {
        (0..shape.sensors).fold(0, |row, s| {
            row | (number >> (shape.sensors - 1 - s) & 1) << s
        })
    })
}

/// Formats a row as `S1…S5 L1L2 R1R2` bits.
fn row_text(table: &Table, row: usize) -> String {
    let shape = table.shape();
    let mut text: String = (0..shape.sensors)
        .map(|s| digit(row >> s & 1 == 1))
        .collect();
    let output = table.output(row);
    for motor in 0..shape.motors {
        text.push(' ');
        text.extend(
            (0..shape.bits).map(|bit| digit(output >> (motor * shape.bits + bit) & 1 == 1)),
        );
    }
    text
}

fn digit(bit: bool) -> char {
    if bit { '1' } else { '0' }
}

fn read_rows(
    rows: &[String],
    shape: Shape,
    genome: &mut Genome,
    first: usize,
) -> std::result::Result<(), String> {
    if rows.len() != shape.rows() {
        return Err(format!(
            "a table has {} rows, needs {}",
            rows.len(),
            shape.rows()
        ));
    }
    let mut seen = vec![false; shape.rows()];
    for text in rows {
        let bits: Vec<bool> = text
            .chars()
            .filter(|c| *c != ' ')
            .map(|c| c == '1')
            .collect();
        let plain = text.chars().all(|c| matches!(c, '0' | '1' | ' '));
        if !plain || bits.len() != shape.sensors + shape.row_bits() {
            return Err(format!(
                "row {text:?} does not have the form \"00000 00 00\", needs S1-S5, L1L2 and R1R2 \
                 as 0 or 1"
            ));
        }
        let (sensors, output) = bits.split_at(shape.sensors);
        let row = sensors
            .iter()
            .enumerate()
            .fold(0, |row, (s, &bit)| row | usize::from(bit) << s);
        if std::mem::replace(&mut seen[row], true) {
            return Err(format!(
                "row {text:?} is duplicated, needs every combination of S1-S5 once"
            ));
        }
        for (bit, &value) in output.iter().enumerate() {
            genome.set(first + row * shape.row_bits() + bit, value);
        }
    }
    Ok(())
}

fn refuse(path: &Path, why: &str) -> Error {
    let cure = format!(
        "if you edited its rows run: ebts show {} --rehash; otherwise use an intact copy",
        path.display()
    );
    Error::Refused(format!(
        "could not use table file {}: {why}; {cure}",
        path.display()
    ))
}

fn quoted(text: &str) -> String {
    toml::Value::from(text).to_string()
}

fn value(value: &impl Serialize) -> String {
    toml::Value::try_from(value).map_or_else(|_| String::new(), |value| inline(&value))
}

/// Formats the entries of a struct, one per line; nested structs inline.
fn entries(fields: &impl Serialize) -> String {
    let table = toml::Table::try_from(fields).unwrap_or_default();
    table.iter().fold(String::new(), |text, (key, value)| {
        format!("{text}{key} = {}\n", inline(value))
    })
}

/// Formats a TOML value on one line. Numbers are written as the shortest f32 representation, as in
/// presets.
#[must_use]
pub fn inline(value: &toml::Value) -> String {
    let list = |values: Vec<String>| values.join(", ");
    match value {
        toml::Value::Float(number) => format!("{:?}", *number as f32),
        toml::Value::Array(values) => format!("[{}]", list(values.iter().map(inline).collect())),
        toml::Value::Table(table) => {
            format!(
                "{{ {} }}",
                list(
                    table
                        .iter()
                        .map(|(key, value)| format!("{key} = {}", inline(value)))
                        .collect()
                )
            )
        }
        plain => plain.to_string(),
    }
}
