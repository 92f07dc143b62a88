//! Built-in tables: examples that run without evolution.

use std::path::Path;

use crate::error::{Error, Result};
use crate::table_file::{Hash, TableFile};

/// Name and text of the built-in tables.
///
/// `r3-two-agents`: the best of seeds 1 to 80 for two agents on preset R3
/// (`ebts experiment fig14 --seeds 80`). `ebts evolve --agents 2 --seed 71` reproduces it bit for
/// bit.
const TABLES: [(&str, &str); 1] = [(
    "r3-two-agents",
    include_str!("../tables/r3-two-agents.toml"),
)];

/// Returns the built-in table with this name, or the table of a file.
///
/// # Errors
/// Neither exists, or the file is not an intact table file.
pub fn table(name: &str) -> Result<TableFile> {
    match TABLES.iter().find(|(ours, _)| *ours == name) {
        Some((_, text)) => TableFile::parse(text, Hash::Required).map_err(Error::from_part),
        None if Path::new(name).exists() => TableFile::read(Path::new(name)),
        None => Err(Error::refused(
            "choose a table",
            format_args!("{name:?} is neither a built-in table nor a file"),
            format_args!(
                "{} or a table file",
                TABLES.map(|(ours, _)| ours).join(", ")
            ),
            "correct --table",
        )),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::evaluate::Evaluator;

    #[test]
    fn built_in_tables_reproduce_stored_points() {
        for (name, _) in TABLES {
            let file = table(name).expect(name);
            let points = Evaluator::points_of(&file.condition, &file.individual.genome);
            assert_eq!(points, file.individual.points, "{name}");
        }
    }
}
