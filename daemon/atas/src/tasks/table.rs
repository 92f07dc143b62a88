//! A behaviour table that feels (paper section III, Table 1): for every combination of sensor bits, what fingers and hand do.
//!
//! Methodology 2 as a part of methodology 1's tasks: the table comes with a task, and the module "behaviour table" reads it.
//! It is generic in the sense of the paper's Eq. 1: S bits out of a declared list, actuators of 1, 2 or 4 levels, so
//! G = 2^S · (E_fingers + E_hand) bits. Fixed capacity, so that it can be handed to the tick without the heap.

use core::fmt;
use shm_schemas::capacity::{LEVELS, SENSOR_BITS, TABLE_WORDS};
use shm_schemas::layout::{FNV_OFFSET, fnv1a};
use shm_schemas::{SensorBit, TableRecord};

/// Fastest closing or opening that a level may ask of a finger, m/s (as `grasp.approach_m_s` may at most be).
pub const CLOSING_MAX_M_S: f64 = 0.02;
/// Bits of one row in a word: two per actuator.
const ROW_BITS: usize = 4;
/// Rows of one word.
const ROWS_PER_WORD: usize = u64::BITS as usize / ROW_BITS;

/// A checked behaviour table.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct BehaviourTable {
    bits: [u32; SENSOR_BITS],
    count: usize,
    fingers_m_s: [f64; LEVELS],
    hand: [f64; LEVELS],
    rows: [u64; TABLE_WORDS],
}

/// What a row tells the actuators.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Action {
    /// Closing speed of the fingers, m/s, negative opens.
    pub fingers_m_s: f64,
    /// Factor on the hand's speed along its path, −1 (back) to 1.
    pub hand: f64,
}

/// What is wrong with a table.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum TableFault {
    /// No bits, or more than fit.
    Bits(usize),
    /// A number that stands for no bit.
    UnknownBit(u32),
    /// The same bit twice.
    Twice(SensorBit),
    /// Levels of an actuator that are not 1, 2 or 4.
    Levels(&'static str, usize),
    /// A level out of its range.
    Level(&'static str, f64, f64),
    /// Other than two to the power of the bits.
    Rows(usize, usize),
    /// A row, from 0, names a level that its actuator does not have.
    NoLevel(usize),
}

impl fmt::Display for TableFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Bits(count) => write!(f, "has {count} sensor bits, needs 1 to {SENSOR_BITS}"),
            Self::UnknownBit(number) => {
                write!(f, "names the sensor bit {number}, which does not exist")
            }
            Self::Twice(bit) => write!(f, "names the sensor bit \"{bit}\" twice"),
            Self::Levels(actuator, count) => {
                write!(
                    f,
                    "has {count} levels for {actuator}, needs 1, 2 or {LEVELS}"
                )
            }
            Self::Level(actuator, level, most) => write!(
                f,
                "has the level {level} for {actuator}, needs a number from {} to {most}",
                -most
            ),
            Self::Rows(rows, needed) => write!(
                f,
                "has {rows} rows, needs {needed}: one per combination of its sensor bits"
            ),
            Self::NoLevel(row) => write!(f, "names in row {row} a level that there is not"),
        }
    }
}

impl BehaviourTable {
    /// A table; `rows` gives for each combination of the bits, the first of which is the lowest of the row's number, the
    /// level of the fingers and that of the hand.
    ///
    /// # Errors
    /// The first [`TableFault`].
    pub fn checked(
        bits: &[SensorBit],
        fingers_m_s: &[f64],
        hand: &[f64],
        rows: impl ExactSizeIterator<Item = [usize; 2]>,
    ) -> Result<Self, TableFault> {
        let mut table = Self {
            bits: checked_bits(bits)?,
            count: bits.len(),
            fingers_m_s: checked_levels("fingers_m_s", fingers_m_s, CLOSING_MAX_M_S)?,
            hand: checked_levels("hand", hand, 1.0)?,
            rows: [0; TABLE_WORDS],
        };
        let needed = 1 << bits.len();
        if rows.len() != needed {
            return Err(TableFault::Rows(rows.len(), needed));
        }
        for (row, [fingers_level, hand_level]) in rows.enumerate() {
            if fingers_level >= fingers_m_s.len() || hand_level >= hand.len() {
                return Err(TableFault::NoLevel(row));
            }
            let levels = (fingers_level | hand_level << (ROW_BITS / 2)) as u64;
            table.rows[row / ROWS_PER_WORD] |= levels << (row % ROWS_PER_WORD * ROW_BITS);
        }
        Ok(table)
    }

    /// The sensor bits, the lowest of the row's number first.
    pub fn bits(&self) -> impl Iterator<Item = SensorBit> + '_ {
        self.bits[..self.count]
            .iter()
            .map(|number| SensorBit(*number))
    }

    /// Number of rows.
    #[must_use]
    pub fn rows(&self) -> usize {
        1 << self.count
    }

    /// Closing speeds of the fingers, m/s, by level; levels that are not used repeat the last.
    #[must_use]
    pub fn fingers_m_s(&self) -> [f64; LEVELS] {
        self.fingers_m_s
    }

    /// Factors on the hand's speed by level; levels that are not used repeat the last.
    #[must_use]
    pub fn hand(&self) -> [f64; LEVELS] {
        self.hand
    }

    /// Level of the fingers and of the hand in a row.
    #[must_use]
    pub fn levels(&self, row: usize) -> [usize; 2] {
        let row = row % self.rows();
        let levels = (self.rows[row / ROWS_PER_WORD] >> (row % ROWS_PER_WORD * ROW_BITS)) as usize;
        [levels % LEVELS, levels / LEVELS % LEVELS]
    }

    /// What a row tells the actuators.
    #[must_use]
    pub fn action(&self, row: usize) -> Action {
        let [fingers, hand] = self.levels(row);
        Action {
            fingers_m_s: self.fingers_m_s[fingers],
            hand: self.hand[hand],
        }
    }

    /// The table as it is recorded.
    #[must_use]
    pub fn record(&self) -> TableRecord {
        let mut record = TableRecord {
            count: self.count as u32,
            bits: self.bits.map(SensorBit),
            fingers_m_s: self.fingers_m_s,
            hand: self.hand,
            rows: self.rows,
            ..TableRecord::default()
        };
        record.hash = hash(&record);
        record
    }

    /// What names the table: equal for equal tables, whatever wrote them.
    #[must_use]
    pub fn hash(&self) -> u64 {
        self.record().hash
    }

    /// The table of a record, if there is one; the error is a record that is not whole.
    ///
    /// # Errors
    /// [`TableFault`]; a wrong hash counts as a wrong number of bits.
    pub fn of_record(record: &TableRecord) -> Result<Option<Self>, TableFault> {
        let count = record.count as usize;
        if count == 0 {
            return Ok(None);
        }
        let bits = record.bits.get(..count);
        let bits = bits
            .filter(|_| hash(record) == record.hash)
            .ok_or(TableFault::Bits(count))?;
        let table = Self {
            bits: checked_bits(bits)?,
            count,
            fingers_m_s: checked_levels("fingers_m_s", &record.fingers_m_s, CLOSING_MAX_M_S)?,
            hand: checked_levels("hand", &record.hand, 1.0)?,
            rows: record.rows,
        };
        Ok(Some(table))
    }
}

fn hash(record: &TableRecord) -> u64 {
    let words = record.bits.iter().map(|bit| u64::from(bit.0));
    let levels = record.fingers_m_s.iter().chain(&record.hand);
    let words = words.chain(levels.map(|level| level.to_bits()));
    words
        .chain(record.rows)
        .chain([u64::from(record.count)])
        .fold(FNV_OFFSET, |hash, word| fnv1a(hash, &word.to_le_bytes()))
}

fn checked_bits(bits: &[SensorBit]) -> Result<[u32; SENSOR_BITS], TableFault> {
    if bits.is_empty() || bits.len() > SENSOR_BITS {
        return Err(TableFault::Bits(bits.len()));
    }
    let mut checked = [SensorBit::NONE.0; SENSOR_BITS];
    for (index, bit) in bits.iter().enumerate() {
        if !bit.is_known() || *bit == SensorBit::NONE {
            return Err(TableFault::UnknownBit(bit.0));
        }
        if bits[..index].contains(bit) {
            return Err(TableFault::Twice(*bit));
        }
        checked[index] = bit.0;
    }
    Ok(checked)
}

fn checked_levels(
    actuator: &'static str,
    levels: &[f64],
    most: f64,
) -> Result<[f64; LEVELS], TableFault> {
    if !matches!(levels.len(), 1 | 2 | LEVELS) {
        return Err(TableFault::Levels(actuator, levels.len()));
    }
    // NaN is in no range.
    if let Some(level) = levels.iter().find(|level| !(-most..=most).contains(*level)) {
        return Err(TableFault::Level(actuator, *level, most));
    }
    Ok(core::array::from_fn(|level| {
        levels[level.min(levels.len() - 1)]
    }))
}
