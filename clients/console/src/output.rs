//! Standard output of the `atas` programs: tables and text for people, JSON lines for programs.

use std::io::{IsTerminal, Write};
use std::ops::Range;

use anyhow::Context;
use clap::ValueEnum;
use comfy_table::{
    Cell, ColumnConstraint, ContentArrangement, LineStyle, Table, TableStyle, Width,
};
use serde::Serialize;
use shm_schemas::ModuleId;

/// Output format.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum Format {
    /// Tables and sentences
    #[default]
    Human,
    /// One JSON value per line on standard output; an error is one JSON object on standard error
    Json,
}

/// Standard output in one [`Format`].
pub struct Output {
    format: Format,
    colour: bool,
    out: std::io::Stdout,
}

impl Output {
    /// Opens standard output. Colours need a terminal and an unset or empty `NO_COLOR`
    /// (no-color.org).
    pub fn new(format: Format) -> Self {
        let wanted = std::env::var_os("NO_COLOR").is_none_or(|value| value.is_empty());
        let out = std::io::stdout();
        Self {
            format,
            colour: wanted && out.is_terminal(),
            out,
        }
    }

    /// Returns true for JSON output.
    #[must_use]
    pub fn is_json(&self) -> bool {
        self.format == Format::Json
    }

    /// Returns true if standard output is a terminal.
    #[must_use]
    pub fn is_terminal(&self) -> bool {
        self.out.is_terminal()
    }

    /// Prints text and a line end.
    pub fn line(&mut self, text: impl std::fmt::Display) -> anyhow::Result<()> {
        writeln!(self.out, "{text}").context("could not write to standard output")
    }

    /// Writes raw bytes and flushes them.
    ///
    /// # Errors
    /// Standard output cannot be written.
    pub fn bytes(&mut self, bytes: &[u8]) -> anyhow::Result<()> {
        self.out
            .write_all(bytes)
            .and_then(|()| self.out.flush())
            .context("could not write to standard output")
    }

    /// Prints one JSON value on one line.
    pub fn json(&mut self, value: &impl Serialize) -> anyhow::Result<()> {
        let text = serde_json::to_string(value).context("could not write JSON")?;
        self.line(text)
    }

    /// Clears the terminal before the next picture of a watched value; does nothing without a
    /// terminal.
    pub fn clear(&mut self) -> anyhow::Result<()> {
        if self.is_terminal() {
            write!(self.out, "\x1b[H\x1b[2J").context("could not write to standard output")?;
        }
        Ok(())
    }

    /// Prints a table as wide as the terminal, or 80 columns without one.
    ///
    /// Columns that do not fit go into further tables below, each of which repeats the first
    /// column. Cells break at spaces; see [`no_break`].
    ///
    /// # Errors
    /// Standard output cannot be written.
    pub fn table(&mut self, table: Table) -> anyhow::Result<()> {
        let terminal = terminal_size::terminal_size_of(&self.out).map(|(columns, _)| columns.0);
        let terminal = terminal.filter(|columns| *columns >= COLUMNS_MIN);
        let columns = terminal
            .filter(|_| self.is_terminal())
            .unwrap_or(COLUMNS_DEFAULT);
        self.line(coloured(fit_to_width(table, columns)))
    }

    /// Builds a table cell whose colour shows the rating.
    #[must_use]
    pub fn rated_cell(&self, text: &str, mood: Rating) -> Cell {
        if !self.colour {
            return Cell::new(text);
        }
        let mark = mood.mark_and_colour().0;
        let words = text
            .split(' ')
            .map(|word| format!("{mark}{word}{END_MARK}"));
        Cell::new(words.collect::<Vec<_>>().join(" "))
    }
}

/// Rating of a result.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rating {
    /// Works as intended.
    Good,
    /// Works with a defect.
    Warning,
    /// Does not work.
    Bad,
}

/// Invisible character of width 0 after each word of a rated cell. [`coloured`] replaces it and the
/// mark before the word, after the table has been laid out.
const END_MARK: char = '\u{2064}';

impl Rating {
    const ALL: [Self; 3] = [Self::Good, Self::Warning, Self::Bad];

    /// Returns the invisible mark before a word, and the terminal's code of the colour.
    fn mark_and_colour(self) -> (char, &'static str) {
        match self {
            Self::Good => ('\u{2061}', "\x1b[32m"),
            Self::Warning => ('\u{2062}', "\x1b[33m"),
            Self::Bad => ('\u{2063}', "\x1b[31m"),
        }
    }
}

/// Replaces the marks of rated cells by colours.
fn coloured(text: String) -> String {
    let marks = Rating::ALL.map(Rating::mark_and_colour);
    let text = marks
        .into_iter()
        .fold(text, |text, (mark, colour)| text.replace(mark, colour));
    text.replace(END_MARK, "\x1b[39m")
}

impl From<bool> for Rating {
    fn from(good: bool) -> Self {
        if good { Self::Good } else { Self::Bad }
    }
}

/// Narrowest terminal width in use, columns. A smaller reported width is taken as an error and
/// ignored.
const COLUMNS_MIN: u16 = 40;
/// Width of a table in a file or pipe, columns.
const COLUMNS_DEFAULT: u16 = 80;

/// Creates a table in the common style of the `atas` programs, for [`Output::table`].
#[must_use]
pub fn table(header: &[&str]) -> Table {
    let mut table = Table::new();
    let lines = TableStyle::new().header_separator(LineStyle::none().fill('─').junction('─'));
    table.load_style(lines).set_header(header);
    table
}

/// Returns the words with no-break spaces: a table keeps them on one line.
#[must_use]
pub fn no_break(words: &str) -> String {
    words.replace(' ', NO_BREAK_SPACE)
}

/// No-break space (U+00A0); printed as an ordinary space.
const NO_BREAK_SPACE: &str = "\u{a0}";
/// Longest word that a table keeps whole, characters. Half of 80 columns (design choice): longer
/// words are paths, which no table can hold.
const WORD_MAX: usize = 40;
/// Space between two columns.
const GAP: u16 = 2;

/// Lays the table out in the given number of columns, as several tables if needed.
fn fit_to_width(mut table: Table, columns: u16) -> String {
    table
        .set_content_arrangement(ContentArrangement::Dynamic)
        .set_width(columns);
    let least = min_widths(&mut table);
    let parts = parts(&least, columns).into_iter().map(|part| {
        let mut shown = table.clone();
        for (column, least) in shown.column_iter_mut().zip(&least) {
            let is_shown = column.index == 0 || part.contains(&column.index);
            column.set_padding((0, 1));
            column.set_constraint(match is_shown {
                true => ColumnConstraint::LowerBoundary(Width::Fixed(least + 1)),
                false => ColumnConstraint::Hidden,
            });
        }
        shown.to_string().replace(NO_BREAK_SPACE, " ")
    });
    parts.collect::<Vec<_>>().join("\n\n")
}

/// Returns the length of each column's longest word.
fn min_widths(table: &mut Table) -> Vec<u16> {
    let longest = |index: usize, table: &Table| {
        let cells = table.column_cells_with_header_iter(index).flatten();
        cells.map(|cell| longest_word(&cell.content())).max()
    };
    (0..table.column_count())
        .map(|index| longest(index, table).unwrap_or(0))
        .collect()
}

/// Groups the columns after the first: as many per part as fit, at least one.
fn parts(least: &[u16], columns: u16) -> Vec<Range<usize>> {
    let first = least.first().map_or(0, |least| least + GAP);
    let (mut parts, mut begin, mut taken) = (Vec::new(), 1, first);
    for (index, least) in least.iter().enumerate().skip(1) {
        // The last column of a part needs no gap.
        if taken + least + GAP > columns + GAP - 1 && index > begin {
            parts.push(begin..index);
            (begin, taken) = (index, first);
        }
        taken += least + GAP;
    }
    parts.push(begin..least.len().max(1));
    parts
}

fn longest_word(text: &str) -> u16 {
    let is_visible = |c: &char| !('\u{2061}'..=END_MARK).contains(c);
    let lengths = text
        .split([' ', '\n'])
        .map(|word| word.chars().filter(is_visible).count());
    lengths.max().unwrap_or(0).min(WORD_MAX) as u16
}

/// Formats a number with the given digits after the point, and zero without a sign.
pub fn number(value: f64, digits: usize) -> String {
    let text = format!("{value:.digits$}");
    let is_zero = text.chars().all(|c| matches!(c, '-' | '0' | '.'));
    match text.strip_prefix('-') {
        Some(zero) if is_zero => zero.to_owned(),
        _ => text,
    }
}

/// Lists the active modules of a bit set by their short names.
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
    fn zero_has_no_minus_sign() {
        let check = |value, digits, expected| assert_eq!(number(value, digits), expected);
        check(-0.004, 2, "0.00");
        check(-0.006, 2, "-0.01");
        check(-0.0, 0, "0");
        check(4.126, 2, "4.13");
        check(f64::NAN, 2, "NaN");
        check(f64::INFINITY, 2, "inf");
    }

    #[test]
    fn colours_do_not_change_the_layout() {
        let output = |colour| Output {
            format: Format::Human,
            colour,
            out: std::io::stdout(),
        };
        let text = |colour| {
            let mut rows = table(&["object", "outcome"]);
            let outcome = "refused: object too heavy for its force limit";
            let cell = output(colour).rated_cell(outcome, Rating::Bad);
            rows.add_row(vec![Cell::new("heavy-block"), cell]);
            coloured(fit_to_width(rows, 40))
        };
        let plain = text(true).replace("\x1b[31m", "").replace("\x1b[39m", "");
        assert_eq!(plain, text(false));
        assert!(
            text(true).contains("\x1b[31mheavy\x1b[39m"),
            "{}",
            text(true)
        );
    }

    #[test]
    fn tables_fit_width_without_breaking_numbers() {
        // `columns`: heading and cell of each column.
        let check = |columns: &[(&str, &str)], wide: u16, parts: usize| {
            let (header, row): (Vec<&str>, Vec<&str>) = columns.iter().copied().unzip();
            let mut rows = table(&header);
            rows.add_row(row.iter().map(|cell| cell.replace('~', NO_BREAK_SPACE)));
            let text = fit_to_width(rows, wide);
            let lengths = text.lines().map(|line| line.chars().count());
            assert!(lengths.max() <= Some(wide.into()), "{text}");
            for word in row.iter().flat_map(|cell| cell.split(' ')) {
                let word = word.replace('~', " ");
                assert!(
                    word.len() > WORD_MAX || text.contains(&word),
                    "{word}:\n{text}"
                );
            }
            let shown = text
                .split("\n\n")
                .filter(|part| part.starts_with(columns[0].0));
            assert_eq!(shown.count(), parts, "{text}");
        };
        let outcome =
            "refused: object too heavy for its hardness, and more words than one line has room for";
        let grasp = [
            ("object", "filled-paper-box"),
            ("needed N", "18.39"),
            ("stiffness N/m", "1000000"),
            ("lifted mm", "39.96"),
            ("outcome", outcome),
        ];
        check(&grasp, 80, 1);
        check(&grasp, 60, 1);
        check(&grasp, 40, 2);
        let ranges = [
            ("family", "filled-paper-box"),
            ("held", "150~of~150"),
            ("over-grip", "1.67~to~11.45"),
            ("slip mm", "0.31~to~6.97"),
            ("turn °", "0.58~to~12.58"),
            ("otherwise", "3 crushed, 2 slipped in the hand"),
        ];
        check(&ranges, 100, 1);
        check(&ranges, 80, 2);
        let path = "/dev/shm/".to_owned() + &"0123456789abcdef".repeat(8);
        check(&[("probe", "bus"), ("found", &path)], 80, 1);
        check(&[("alone", "1")], 40, 1);
    }

    #[test]
    fn modules_are_listed_by_name() {
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
