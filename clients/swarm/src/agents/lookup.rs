//! Lookup of behaviour tables: row in, output bits out.

use field::ROWS;
use sim_backend::course::{Host, Responses};

use crate::files::sha256;
use crate::table::Table;
use crate::table_file::TableFile;

/// Tables of a team, prepared for lookup.
#[derive(Clone, Debug)]
pub struct Lookup {
    /// Per table, the output bits of every row of the field.
    outputs: Vec<[u32; ROWS]>,
    hash: u64,
    /// Hash of the field of the tables; for several fields that of the first file.
    field_hash: u64,
}

impl Lookup {
    /// Prepares the tables of validated files in order.
    #[must_use]
    pub fn new(files: &[TableFile]) -> Self {
        let hash = match files {
            [file] => file.hash(),
            _ => sha256(
                files
                    .iter()
                    .map(TableFile::hash)
                    .collect::<String>()
                    .as_bytes(),
            ),
        };
        Self {
            outputs: files.iter().flat_map(outputs).collect(),
            hash: u64::from_str_radix(&hash[..16], 16).unwrap_or(0),
            field_hash: files.first().map_or(0, field_hash),
        }
    }

    /// Prepares the table of a course file with this hash.
    #[must_use]
    pub fn from_course(hash: &str, table: Responses) -> Self {
        Self {
            outputs: vec![std::array::from_fn(|row| table.get(row as u8).motor_bits())],
            hash: u64::from_str_radix(hash, 16).unwrap_or(0),
            field_hash: Host::field_hash(),
        }
    }

    /// Returns the number of tables.
    #[must_use]
    pub fn tables(&self) -> usize {
        self.outputs.len()
    }

    /// Returns the first eight bytes of the file's hash; for several files, of the SHA-256 over
    /// their hashes.
    #[must_use]
    pub fn hash(&self) -> u64 {
        self.hash
    }

    /// Returns the hash of the field of the tables, see [`field::Preset::fingerprint`] and
    /// [`Host::field_hash`].
    #[must_use]
    pub fn field_hash(&self) -> u64 {
        self.field_hash
    }

    /// Writes per agent the output bits (L1 lowest, then L2, R1, R2) of the row that its sensors
    /// select. Row bits: IR left is bit 0, then IR front, IR right, photo left, photo right; higher
    /// bits are ignored. Agents are assigned to tables cyclically. The shorter slice limits the
    /// number of agents.
    pub fn answer(&self, rows: &[u32], outputs: &mut [u32]) {
        let tables = self.outputs.iter().cycle();
        for ((row, output), table) in rows.iter().zip(outputs).zip(tables) {
            *output = table[*row as usize % ROWS];
        }
    }
}

/// Returns the hash of the field that a file's tables were evolved for.
#[must_use]
pub fn field_hash(file: &TableFile) -> u64 {
    file.condition.model.preset().fingerprint()
}

fn outputs(file: &TableFile) -> Vec<[u32; ROWS]> {
    let sensors = file.condition.sensors;
    let outputs = |table: &Table| {
        std::array::from_fn(|field_row| table.output(sensors.table_row(field_row as u8)))
    };
    let tables = file.condition.tables_of(&file.individual.genome);
    tables.iter().map(outputs).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::course::table_file::{BUILT_IN, CourseFile};
    use crate::table_file::Hash;
    use sim_backend::course::Wheels;

    #[test]
    fn lookup_matches_the_table() {
        let text = include_str!("../../tests/golden/table.toml");
        let file = TableFile::parse(text, Hash::Required).expect("an intact file");
        let lookup = Lookup::new(std::slice::from_ref(&file));
        let rows: Vec<u32> = (0..1000).map(|agent| agent * 7 % 32).collect();
        let mut outputs = vec![99; rows.len()];
        lookup.answer(&rows, &mut outputs);
        let table = &file.condition.tables_of(&file.individual.genome)[0];
        for (row, output) in rows.iter().zip(&outputs) {
            assert_eq!(*output, table.output(*row as usize), "row {row}");
        }
        assert!(file.hash().starts_with(&format!("{:016x}", lookup.hash())));
    }

    #[test]
    fn course_table_answers_with_its_wheel_levels() {
        let (file, table) = CourseFile::from_name(BUILT_IN).expect("it ships");
        let lookup = Lookup::from_course(&file.hash, table);
        let (rows, mut outputs): (Vec<u32>, _) = ((0..ROWS as u32).collect(), [99; ROWS]);
        lookup.answer(&rows, &mut outputs);
        for (row, output) in rows.iter().zip(outputs) {
            let wheels = Wheels::from_motor_bits(output);
            assert_eq!(wheels, table.get(*row as u8), "row {row}");
        }
        assert_eq!(format!("{:016x}", lookup.hash()), file.hash);
    }
}
