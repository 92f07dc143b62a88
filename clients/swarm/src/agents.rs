//! The agents' side of a field that somebody else runs: rows in, output bits out, table by table.
//!
//! A [`Lookup`] is all an agents process needs per frame. A process that takes tables while it runs builds the new `Lookup`
//! first and exchanges it between two frames: a file that cannot be used never replaces the one in use.
//!
//! Deliberately absent: how rows and outputs travel.

use field::ROWS;

use crate::table_file::TableFile;

/// The tables of a team, ready to be looked up.
#[derive(Clone, Debug)]
pub struct Lookup {
    /// Per table, the output bits of every row of the field.
    outputs: Vec<[u32; ROWS]>,
    hash: u64,
}

impl Lookup {
    /// Prepares the tables of a checked file.
    #[must_use]
    pub fn new(file: &TableFile) -> Self {
        let sensors = file.condition.sensors;
        let tables = file.condition.tables_of(&file.individual.genome);
        let outputs = |table: &crate::table::Table| {
            std::array::from_fn(|field_row| table.output(sensors.table_row(field_row as u8)))
        };
        let hash = u64::from_str_radix(&file.hash()[..16], 16).unwrap_or(0);
        Self {
            outputs: tables.iter().map(outputs).collect(),
            hash,
        }
    }

    /// The first eight bytes of the file's hash, as a number.
    #[must_use]
    pub fn hash(&self) -> u64 {
        self.hash
    }

    /// Per agent, the output bits (L1 lowest, then L2, R1, R2) for the row its sensors select: IR left is bit 0, then IR
    /// front, IR right, photo left, photo right. Agents take the file's tables in turn; of a row only the lowest five bits
    /// matter. As many agents as the shorter slice has.
    pub fn answer(&self, rows: &[u32], outputs: &mut [u32]) {
        let tables = self.outputs.iter().cycle();
        for ((row, output), table) in rows.iter().zip(outputs).zip(tables) {
            *output = table[*row as usize % ROWS];
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::table_file::Hash;

    #[test]
    fn agents_do_what_their_table_says() {
        let text = include_str!("../tests/golden/table.toml");
        let file = TableFile::parse(text, Hash::Required).expect("an intact file");
        let lookup = Lookup::new(&file);
        let rows: Vec<u32> = (0..1000).map(|agent| agent * 7 % 32).collect();
        let mut outputs = vec![99; rows.len()];
        lookup.answer(&rows, &mut outputs);
        let table = &file.condition.tables_of(&file.individual.genome)[0];
        for (row, output) in rows.iter().zip(&outputs) {
            assert_eq!(*output, table.output(*row as usize), "row {row}");
        }
        assert!(file.hash().starts_with(&format!("{:016x}", lookup.hash())));
    }
}
