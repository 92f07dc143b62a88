//! Behaviour table (paper III, Table 1): actions of fingers and hand per combination of sensor
//! bits.
//!
//! The behaviour table module reads the table of a task. Generalises the paper's Eq. 1 to S
//! declared bits and actuators of 1, 2 or 4 levels: G = 2^S · (E_fingers + E_hand) bits. Fixed
//! capacity, so the tick needs no heap.

use core::fmt;
use shm_schemas::capacity::{LEVELS, SENSOR_BITS, TABLE_WORDS};
use shm_schemas::layout::{FNV_OFFSET, fnv1a};
use shm_schemas::{SensorBit, TableRecord};

/// Maximum closing or opening speed of a level, m/s (equals the maximum of `grasp.approach_m_s`).
pub const CLOSING_MAX_M_S: f64 = 0.02;
/// Bits per row: two per actuator.
const ROW_BITS: usize = 4;
const ROWS_PER_WORD: usize = u64::BITS as usize / ROW_BITS;

/// Validated behaviour table.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct BehaviourTable {
    bits: [u32; SENSOR_BITS],
    count: usize,
    fingers_m_s: [f64; LEVELS],
    hand: [f64; LEVELS],
    rows: [u64; TABLE_WORDS],
}

/// Actuator commands of one row.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Action {
    /// Closing speed of the fingers, m/s; negative values open.
    pub fingers_m_s: f64,
    /// Factor on the path speed of the hand, −1 (back) to 1.
    pub hand: f64,
}

/// Error in a table.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum TableError {
    /// No bits, or too many.
    BitCount(usize),
    /// Number without a sensor bit.
    UnknownBit(u32),
    /// Duplicate bit.
    DuplicateBit(SensorBit),
    /// Level count other than 1, 2 or 4.
    LevelCount(&'static str, usize),
    /// Level out of range.
    LevelRange(&'static str, f64, f64),
    /// Row count other than two to the power of the bits.
    RowCount(usize, usize),
    /// Row, from 0, with a level that its actuator lacks.
    UnknownLevel(usize),
}

impl fmt::Display for TableError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::BitCount(count) => write!(f, "has {count} sensor bits, needs 1 to {SENSOR_BITS}"),
            Self::UnknownBit(number) => {
                write!(f, "names sensor bit {number}, which does not exist")
            }
            Self::DuplicateBit(bit) => write!(f, "names sensor bit \"{bit}\" twice"),
            Self::LevelCount(actuator, count) => {
                write!(
                    f,
                    "has {count} levels for {actuator}, needs 1, 2 or {LEVELS}"
                )
            }
            Self::LevelRange(actuator, level, most) => write!(
                f,
                "has level {level} for {actuator}, needs a number from {} to {most}",
                -most
            ),
            Self::RowCount(rows, needed) => write!(
                f,
                "has {rows} rows, needs {needed}: one per combination of its sensor bits"
            ),
            Self::UnknownLevel(row) => write!(f, "names an unknown level in row {row}"),
        }
    }
}

impl BehaviourTable {
    /// Validates a table. `rows` gives the level of fingers and hand per combination of bits; the
    /// first bit is the lowest of the row number.
    ///
    /// # Errors
    /// The first [`TableError`].
    pub fn validated(
        bits: &[SensorBit],
        fingers_m_s: &[f64],
        hand: &[f64],
        rows: impl ExactSizeIterator<Item = [usize; 2]>,
    ) -> Result<Self, TableError> {
        let mut table = Self {
            bits: validated_bits(bits)?,
            count: bits.len(),
            fingers_m_s: validated_levels("fingers_m_s", fingers_m_s, CLOSING_MAX_M_S)?,
            hand: validated_levels("hand", hand, 1.0)?,
            rows: [0; TABLE_WORDS],
        };
        let needed = 1 << bits.len();
        if rows.len() != needed {
            return Err(TableError::RowCount(rows.len(), needed));
        }
        for (row, [fingers_level, hand_level]) in rows.enumerate() {
            if fingers_level >= fingers_m_s.len() || hand_level >= hand.len() {
                return Err(TableError::UnknownLevel(row));
            }
            let levels = (fingers_level | hand_level << (ROW_BITS / 2)) as u64;
            table.rows[row / ROWS_PER_WORD] |= levels << (row % ROWS_PER_WORD * ROW_BITS);
        }
        Ok(table)
    }

    /// Returns the sensor bits, starting with the lowest of the row number.
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

    /// Closing speed per level, m/s; unused levels repeat the last one.
    #[must_use]
    pub fn fingers_m_s(&self) -> [f64; LEVELS] {
        self.fingers_m_s
    }

    /// Path speed factor per level; unused levels repeat the last one.
    #[must_use]
    pub fn hand(&self) -> [f64; LEVELS] {
        self.hand
    }

    /// Returns the levels of fingers and hand in a row.
    #[must_use]
    pub fn levels(&self, row: usize) -> [usize; 2] {
        let row = row % self.rows();
        let levels = (self.rows[row / ROWS_PER_WORD] >> (row % ROWS_PER_WORD * ROW_BITS)) as usize;
        [levels % LEVELS, levels / LEVELS % LEVELS]
    }

    /// Returns the actuator commands of a row.
    #[must_use]
    pub fn action(&self, row: usize) -> Action {
        let [fingers, hand] = self.levels(row);
        Action {
            fingers_m_s: self.fingers_m_s[fingers],
            hand: self.hand[hand],
        }
    }

    /// Returns the table in recorded form.
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

    /// Hash of the content; equal for equal tables.
    #[must_use]
    pub fn hash(&self) -> u64 {
        self.record().hash
    }

    /// Returns the table of a record, if it contains one.
    ///
    /// # Errors
    /// [`TableError`]; a wrong hash counts as a wrong number of bits.
    pub fn from_record(record: &TableRecord) -> Result<Option<Self>, TableError> {
        let count = record.count as usize;
        if count == 0 {
            return Ok(None);
        }
        let bits = record.bits.get(..count);
        let bits = bits
            .filter(|_| hash(record) == record.hash)
            .ok_or(TableError::BitCount(count))?;
        let table = Self {
            bits: validated_bits(bits)?,
            count,
            fingers_m_s: validated_levels("fingers_m_s", &record.fingers_m_s, CLOSING_MAX_M_S)?,
            hand: validated_levels("hand", &record.hand, 1.0)?,
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

fn validated_bits(bits: &[SensorBit]) -> Result<[u32; SENSOR_BITS], TableError> {
    if bits.is_empty() || bits.len() > SENSOR_BITS {
        return Err(TableError::BitCount(bits.len()));
    }
    let mut checked = [SensorBit::NONE.0; SENSOR_BITS];
    for (index, bit) in bits.iter().enumerate() {
        if !bit.is_known() || *bit == SensorBit::NONE {
            return Err(TableError::UnknownBit(bit.0));
        }
        if bits[..index].contains(bit) {
            return Err(TableError::DuplicateBit(*bit));
        }
        checked[index] = bit.0;
    }
    Ok(checked)
}

fn validated_levels(
    actuator: &'static str,
    levels: &[f64],
    most: f64,
) -> Result<[f64; LEVELS], TableError> {
    if !matches!(levels.len(), 1 | 2 | LEVELS) {
        return Err(TableError::LevelCount(actuator, levels.len()));
    }
    // NaN is outside every range.
    if let Some(level) = levels.iter().find(|level| !(-most..=most).contains(*level)) {
        return Err(TableError::LevelRange(actuator, *level, most));
    }
    Ok(core::array::from_fn(|level| {
        levels[level.min(levels.len() - 1)]
    }))
}
