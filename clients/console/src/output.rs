//! Standard output: results for people or for programs.

use std::io::{IsTerminal, Write};

use anyhow::Context;
use clap::ValueEnum;
use comfy_table::{Cell, Color, ContentArrangement, LineStyle, Table, TableStyle};
use serde::Serialize;
use shm_schemas::ModuleId;

/// How results are printed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum Format {
    /// Tables and sentences
    #[default]
    Human,
    /// One JSON value per line
    Json,
}

/// Standard output in one format.
pub struct Output {
    format: Format,
    colour: bool,
    out: std::io::Stdout,
}

impl Output {
    /// Standard output. Colours only on a terminal, and not if `NO_COLOR` is set to anything (no-color.org).
    pub fn new(format: Format) -> Self {
        let wanted = std::env::var_os("NO_COLOR").is_none_or(|value| value.is_empty());
        let out = std::io::stdout();
        Self {
            format,
            colour: wanted && out.is_terminal(),
            out,
        }
    }

    /// Whether results are for programs.
    #[must_use]
    pub fn is_json(&self) -> bool {
        self.format == Format::Json
    }

    /// Whether somebody watches.
    #[must_use]
    pub fn is_terminal(&self) -> bool {
        self.out.is_terminal()
    }

    /// Prints one line, or several.
    pub fn line(&mut self, text: impl std::fmt::Display) -> anyhow::Result<()> {
        writeln!(self.out, "{text}").context("could not write to standard output")
    }

    /// Prints one JSON value on one line.
    pub fn json(&mut self, value: &impl Serialize) -> anyhow::Result<()> {
        let text = serde_json::to_string(value).context("could not write JSON")?;
        self.line(text)
    }

    /// Clears the terminal for the next picture of a watched value.
    pub fn clear(&mut self) -> anyhow::Result<()> {
        if self.is_terminal() {
            write!(self.out, "\x1b[H\x1b[2J").context("could not write to standard output")?;
        }
        Ok(())
    }

    /// A cell that says whether something went well: green or red where colours are wanted.
    pub fn verdict(&self, text: &str, good: bool) -> Cell {
        let cell = Cell::new(text);
        match (self.colour, good) {
            (true, true) => cell.fg(Color::Green),
            (true, false) => cell.fg(Color::Red),
            (false, _) => cell,
        }
    }
}

/// Columns below which a terminal's width is not believed: nothing could be read there.
const COLUMNS_MIN: u16 = 40;

/// A table in the one style of this program, wrapped to the terminal's width.
pub fn table(header: &[&str]) -> Table {
    let mut table = Table::new();
    let lines = TableStyle::new().header_separator(LineStyle::none().fill('─').junction('─'));
    table.load_style(lines).set_header(header);
    if table.width().is_none_or(|columns| columns >= COLUMNS_MIN) {
        table.set_content_arrangement(ContentArrangement::Dynamic);
    }
    table
}

/// A number with so many digits after the point, and no minus before a zero.
pub fn number(value: f64, digits: usize) -> String {
    let text = format!("{value:.digits$}");
    let is_zero = text.chars().all(|c| matches!(c, '-' | '0' | '.'));
    match text.strip_prefix('-') {
        Some(zero) if is_zero => zero.to_owned(),
        _ => text,
    }
}

/// The active modules of a bit set, by the short forms of their names.
pub fn modules(active: u32) -> String {
    let is_active = |id: &&ModuleId| id.0 < u32::BITS && active & (1 << id.0) != 0;
    let names: Vec<&str> = ModuleId::ALL
        .iter()
        .filter(is_active)
        .map(|id| id.name())
        .collect();
    if names.is_empty() {
        "none".into()
    } else {
        names.join(" + ")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_without_minus_zero() {
        let check = |value, digits, expected| assert_eq!(number(value, digits), expected);
        check(-0.004, 2, "0.00");
        check(-0.006, 2, "-0.01");
        check(-0.0, 0, "0");
        check(4.126, 2, "4.13");
        check(f64::NAN, 2, "NaN");
        check(f64::INFINITY, 2, "inf");
    }

    #[test]
    fn modules_by_name() {
        let check = |active: u32, expected| assert_eq!(modules(active), expected);
        check(0, "none");
        check(1 << ModuleId::SLIP.0, "module 2, slip");
        check(
            1 << ModuleId::SLIP.0 | 1 << ModuleId::FORCE_LIMIT.0,
            "module 2, slip + module 3, force limit",
        );
        check(1 << 31, "none");
    }
}
