//! `ebts show` of a grasp table.

use std::fmt::Write as _;
use std::path::Path;

use serde::Serialize;

use ebts::error::{Error, Result};
use ebts::evaluate::GoalPoints;
use ebts::files::read_text;
use ebts::grasp::course;
use ebts::grasp::description::{ModuleMatches, describe_rows, match_modules};
use ebts::grasp::evolve::evaluate_table;
use ebts::grasp::table_file::GraspFile;

use super::{Format, answer, print};

pub(in crate::cli) fn is_grasp_file(path: &Path) -> Result<bool> {
    Ok(GraspFile::is_grasp_file(&read_text(path)?))
}

#[derive(Serialize)]
struct Shown {
    seed: u64,
    generations: u32,
    fitness: f32,
    points: GoalPoints,
    hash: String,
    rows_read: Vec<String>,
    again: ModuleMatches,
}

pub(in crate::cli) fn show(path: &Path, task: Option<&str>, format: Format) -> Result<()> {
    let families = course::families()?;
    let (file, table) = GraspFile::read(path, &families)?;
    if let Some(name) = task {
        return print(file.to_task(name).as_bytes());
    }
    let genome = course::genome(&table).ok_or_else(|| {
        Error::from_part(
            "the bits or levels are not \
        those of the course",
        )
    })?;
    let (_, read, outcomes) = evaluate_table(&families, &genome, file.force_limit);
    let rows = describe_rows(&table, read);
    let again = match_modules(&table, read);
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
                family.members[0].required_n(),
                outcome.time_s
            );
        }
        text += "Rows that were read:\n";
        text += &rows;
        text += "Rows with the action of a module, of the rows to which it applies:\n";
        for (name, found) in [
            ("module 1: close below F_1", again.module_1),
            ("module 2: close while slipping below F_2", again.module_2),
            ("module 3: do not close above F_2", again.module_3),
            (
                "refusing: withdraw from an object that slips above F_2",
                again.refusing,
            ),
            (
                "giving back: open while friction is in excess",
                again.giving_back,
            ),
        ] {
            let _ = writeln!(text, "  {name}: {} of {}", found.answered, found.asked);
        }
        text
    })
}
