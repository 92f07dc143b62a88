//! `ebts show` of a grasp table.

use std::fmt::Write as _;
use std::path::Path;

use serde::Serialize;

use ebts::error::{Error, Result};
use ebts::evaluate::GoalPoints;
use ebts::files::read_text;
use ebts::grasp::course;
use ebts::grasp::evolve::evaluate_table;
use ebts::grasp::table_file::GraspFile;
use ebts::grasp::words::{Again, found_again, sentences};

use super::{Format, answer, print};

pub(in crate::cli) fn is_grasp_file(path: &Path) -> Result<bool> {
    Ok(GraspFile::is_one(&read_text(path)?))
}

#[derive(Serialize)]
struct Shown {
    seed: u64,
    generations: u32,
    fitness: f32,
    points: GoalPoints,
    hash: String,
    rows_read: Vec<String>,
    again: Again,
}

pub(in crate::cli) fn show(path: &Path, task: Option<&str>, format: Format) -> Result<()> {
    let families = course::families()?;
    let (file, table) = GraspFile::read(path, &families)?;
    if let Some(name) = task {
        return print(file.task(name).as_bytes());
    }
    let genome = course::genome(&table).ok_or_else(|| Error::from_part("not of the course"))?;
    let (_, read, outcomes) = evaluate_table(&families, &genome, file.force_limit);
    let rows = sentences(&table, read);
    let again = found_again(&table, read);
    let shown = Shown {
        seed: file.seed,
        generations: file.generations,
        fitness: file.fitness(),
        points: file.points,
        hash: file.hash.clone(),
        rows_read: rows.lines().map(|line| line.trim().to_owned()).collect(),
        again,
    };
    answer(format, &shown, || {
        let mut text = format!(
            "{}: fitness {:.1} of 800, seed {}, {} generations, hash {}\n",
            path.display(),
            shown.fitness,
            file.seed,
            file.generations,
            file.hash
        );
        for ((family, points), outcome) in families.iter().zip(file.points).zip(&outcomes) {
            let _ = writeln!(
                text,
                "  {:<18} {points:>5.1}  {:?}, F_n {:.2} N of {:.2} N needed, {:.1} s",
                family.name,
                outcome.end,
                outcome.normal_n,
                family.members[0].needed_n(),
                outcome.time_s
            );
        }
        text += "Rows that were read:\n";
        text += &rows;
        text += "Of the rows that ask for it, so many do what it says:\n";
        for (name, found) in [
            ("module 1: close below F_1", again.module_1),
            ("module 2: close while slipping below F_2", again.module_2),
            ("module 3: do not close above F_2", again.module_3),
            ("refusing: back from what slips above F_2", again.refusing),
            (
                "giving back: open while friction is spare",
                again.giving_back,
            ),
        ] {
            let _ = writeln!(text, "  {name}: {} of {}", found.answered, found.asked);
        }
        text
    })
}
