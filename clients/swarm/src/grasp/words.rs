//! A table in words: what each row that was read does, and which of the paper's modules it amounts to.

use std::fmt::Write as _;

use atas_core::tasks::BehaviourTable;
use serde::Serialize;
use shm_schemas::SensorBit;

use super::course::{BITS, GENOME_BITS};
use super::rules::{BACK, CLOSE, FULL, HOLD, OPEN, SLOWLY, holds};

/// A module of the paper, as far as rows of a table can be one.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Found {
    /// Rows that were read in which the module would say something.
    pub asked: usize,
    /// Of these, rows that do what it says.
    pub answered: usize,
}

/// Which of the paper's modules a table has found again. Module 4 ends screwing and placing, which this course does not ask for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Again {
    /// Closes while it touches with less than F_1.
    pub module_1: Found,
    /// Closes while it slips below F_2.
    pub module_2: Found,
    /// Does not close above F_2.
    pub module_3: Found,
    /// Takes the hand back from what slips above F_2 (ours).
    pub refusing: Found,
    /// Opens while friction is spare (ours).
    pub giving_back: Found,
}

/// Rows of a bit mask of rows that were read.
fn rows_of(read: u64) -> impl Iterator<Item = usize> {
    (0..GENOME_BITS / 4).filter(move |row| read >> row & 1 == 1)
}

/// Which modules the rows that were read amount to.
#[must_use]
pub fn found_again(table: &BehaviourTable, read: u64) -> Again {
    let count = |asks: &dyn Fn(usize) -> bool, answers: &dyn Fn([usize; 2]) -> bool| {
        let asked: Vec<usize> = rows_of(read).filter(|row| asks(*row)).collect();
        Found {
            answered: asked
                .iter()
                .filter(|row| answers(table.levels(**row)))
                .count(),
            asked: asked.len(),
        }
    };
    let closes = |[fingers, _]: [usize; 2]| fingers >= CLOSE;
    let touches = |row| holds(row, SensorBit::TOUCHING);
    let above_f1 = |row| holds(row, SensorBit::ABOVE_F1);
    let above_f2 = |row| holds(row, SensorBit::ABOVE_F2);
    let slips = |row| holds(row, SensorBit::SLIPPING);
    let spare = |row| holds(row, SensorBit::SPARE);
    Again {
        module_1: count(&|row| touches(row) && !above_f1(row), &closes),
        module_2: count(
            &|row| touches(row) && above_f1(row) && slips(row) && !above_f2(row),
            &closes,
        ),
        module_3: count(&above_f2, &|levels| !closes(levels)),
        refusing: count(&|row| slips(row) && above_f2(row), &|[_, hand]| {
            hand == BACK
        }),
        giving_back: count(&|row| spare(row) && above_f1(row), &|[fingers, _]| {
            fingers == OPEN
        }),
    }
}

/// The rows that were read, one per line.
#[must_use]
pub fn sentences(table: &BehaviourTable, read: u64) -> String {
    let mut text = String::new();
    for row in rows_of(read) {
        // Writing to a string cannot fail.
        let _ = writeln!(text, "  row {row:>2}: {}", sentence(table, row));
    }
    text
}

/// What a row says: `touching, above-f1: fingers hold, hand at full speed`.
#[must_use]
pub fn sentence(table: &BehaviourTable, row: usize) -> String {
    let told: Vec<&str> = BITS
        .into_iter()
        .filter(|bit| holds(row, *bit))
        .map(SensorBit::name)
        .collect();
    let told = match told.is_empty() {
        true => "nothing".to_owned(),
        false => told.join(", "),
    };
    let [fingers, hand] = table.levels(row);
    let fingers = match fingers {
        HOLD => "hold",
        OPEN => "open slowly",
        CLOSE => "close slowly",
        _ => "close fast",
    };
    let hand = match hand {
        BACK => "back slowly",
        SLOWLY => "on slowly",
        FULL => "on at full speed",
        _ => "stands",
    };
    format!("{told}: fingers {fingers}, hand {hand}")
}
