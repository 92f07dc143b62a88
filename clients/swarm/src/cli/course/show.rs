//! `ebts show` of a course table.

use std::fmt::Write as _;
use std::path::Path;

use serde::Serialize;

use ebts::course::fitness::held_out;
use ebts::course::table_file::CourseFile;
use ebts::error::Result;
use ebts::evaluate::GoalPoints;
use ebts::files::read_text;
use ebts::table::behaviour;
use field::{ROWS, SENSORS};

use super::evolve::HELD_OUT;
use super::{Format, answer};

const NAMES: [&str; SENSORS] = [
    "IR left",
    "IR front",
    "IR right",
    "light left",
    "light right",
];

pub(in crate::cli) fn is_course_file(path: &Path) -> Result<bool> {
    Ok(CourseFile::is_course_file(&read_text(path)?))
}

#[derive(Serialize)]
struct Shown {
    seed: u64,
    generations: u32,
    fitness: f32,
    points: GoalPoints,
    held_out: [f64; 2],
    hash: String,
    rows: Vec<ShownRow>,
}

#[derive(Serialize)]
struct ShownRow {
    sensors: Vec<&'static str>,
    wheels: [u8; 2],
    behaviour: &'static str,
    read: bool,
}

pub(in crate::cli) fn show(path: &Path, format: Format) -> Result<()> {
    let (file, table, rows_read) = CourseFile::read(path)?;
    let row = |row: usize| {
        let wheels = table.get(row as u8);
        let reported = (0..SENSORS).filter(|bit| row >> bit & 1 == 1);
        ShownRow {
            sensors: reported.map(|bit| NAMES[bit]).collect(),
            wheels: [wheels.left, wheels.right],
            behaviour: behaviour(wheels.left.into(), wheels.right.into()),
            read: rows_read >> row & 1 == 1,
        }
    };
    let shown = Shown {
        seed: file.seed,
        generations: file.generations,
        fitness: file.fitness(),
        points: file.points,
        held_out: [held_out(table, 1, HELD_OUT)?, held_out(table, 2, HELD_OUT)?],
        hash: file.hash,
        rows: (0..ROWS).map(row).collect(),
    };
    answer(format, &shown, || describe(path, &shown))
}

fn describe(path: &Path, shown: &Shown) -> String {
    let [one, two] = shown.held_out.map(|share| share * 100.0);
    let mut text = format!(
        "{}: fitness {:.1} of 800, seed {}, {} generations, hash {}\n\
         of {HELD_OUT} unseen courses with hands as time delays: {one:.0} % with one robot, {two:.0} % with two\n\
         Rows that were read:\n",
        path.display(),
        shown.fitness,
        shown.seed,
        shown.generations,
        shown.hash,
    );
    for (index, row) in shown.rows.iter().enumerate().filter(|(_, row)| row.read) {
        let sensors = match row.sensors.is_empty() {
            true => "nothing".to_owned(),
            false => row.sensors.join(", "),
        };
        let [left, right] = row.wheels;
        let _ = writeln!(
            text,
            "  row {index:>2}: {sensors}: {} (wheels {left} {right})",
            row.behaviour
        );
    }
    text
}
