//! Textual description of a table: the action of each row that was read, and its correspondence to
//! the paper's modules.

use std::fmt::Write as _;

use atas_core::tasks::BehaviourTable;
use serde::Serialize;
use shm_schemas::SensorBit;

use super::course::{BITS, GENOME_BITS};
use super::rules::{BACK, CLOSE, FULL, HOLD, OPEN, SLOWLY, is_set};

/// Correspondence of a table to one module.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct ModuleMatch {
    /// Rows that were read in which the module would act.
    pub asked: usize,
    /// Of these, rows with the action of the module.
    pub answered: usize,
}

/// Correspondence of a table to the paper's modules. Module 4 ends screwing and placing and does
/// not apply here.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct ModuleMatches {
    /// Closes while touching with less than F_1.
    pub module_1: ModuleMatch,
    /// Closes while slipping below F_2.
    pub module_2: ModuleMatch,
    /// Does not close above F_2.
    pub module_3: ModuleMatch,
    /// Withdraws the hand from an object that slips above F_2 (not in the paper).
    pub refusing: ModuleMatch,
    /// Opens while friction is in excess (not in the paper).
    pub giving_back: ModuleMatch,
}

fn rows_of(read: u64) -> impl Iterator<Item = usize> {
    (0..GENOME_BITS / 4).filter(move |row| read >> row & 1 == 1)
}

/// Compares the rows that were read with the modules.
#[must_use]
pub fn match_modules(table: &BehaviourTable, read: u64) -> ModuleMatches {
    let count = |asks: &dyn Fn(usize) -> bool, answers: &dyn Fn([usize; 2]) -> bool| {
        let asked: Vec<usize> = rows_of(read).filter(|row| asks(*row)).collect();
        ModuleMatch {
            answered: asked
                .iter()
                .filter(|row| answers(table.levels(**row)))
                .count(),
            asked: asked.len(),
        }
    };
    let closes = |[fingers, _]: [usize; 2]| fingers >= CLOSE;
    let touches = |row| is_set(row, SensorBit::TOUCHING);
    let above_f1 = |row| is_set(row, SensorBit::ABOVE_F1);
    let above_f2 = |row| is_set(row, SensorBit::ABOVE_F2);
    let slips = |row| is_set(row, SensorBit::SLIPPING);
    let spare = |row| is_set(row, SensorBit::FRICTION_MARGIN);
    ModuleMatches {
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

/// Formats the rows that were read, one per line.
#[must_use]
pub fn describe_rows(table: &BehaviourTable, read: u64) -> String {
    let mut text = String::new();
    for row in rows_of(read) {
        let _ = writeln!(text, "  row {row:>2}: {}", describe_row(table, row));
    }
    text
}

/// Formats a row: `touching, above-f1: fingers hold, hand on at full speed`.
#[must_use]
pub fn describe_row(table: &BehaviourTable, row: usize) -> String {
    let reported: Vec<&str> = BITS
        .into_iter()
        .filter(|bit| is_set(row, *bit))
        .map(SensorBit::name)
        .collect();
    let reported = match reported.is_empty() {
        true => "nothing".to_owned(),
        false => reported.join(", "),
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
    format!("{reported}: fingers {fingers}, hand {hand}")
}
