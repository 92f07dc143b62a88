//! Behaviour table: validation and the module that reads it.

use crate::bench::{Bench, pressed, with_utilisation};
use atas_core::modules::Verdict;
use atas_core::tasks::{BehaviourTable, GRASP, Rule, Step, TableError, Task};
use proptest::prelude::*;
use shm_schemas::{ModuleId, ReasonRecord, SensorBit};

const BITS: [SensorBit; 2] = [SensorBit::SLIPPING, SensorBit::ABOVE_F2];
const FINGERS: [f64; 4] = [0.0, -0.001, 0.002, 0.004];
const HAND: [f64; 4] = [0.0, -0.1, 0.1, 1.0];

/// Row 0 holds and continues; slip closes slowly; above F_2 opens and stops; both moves back.
fn table() -> BehaviourTable {
    let rows = [[0, 3], [2, 2], [1, 0], [0, 1]];
    BehaviourTable::validated(&BITS, &FINGERS, &HAND, rows.into_iter()).unwrap()
}

fn bench() -> Bench {
    let mut bench = Bench::new(ModuleId::BEHAVIOUR_TABLE);
    bench.table = Some(table());
    bench
}

#[test]
fn condition_bits_select_the_proposed_row() {
    // F_2 on the bench is 4 N.
    let cases = [
        (pressed(2.0), 0.0, 1.0),
        (with_utilisation(2.0, 1.0), 0.002, 0.1),
        (pressed(4.5), -0.001, 0.0),
        (with_utilisation(4.5, 1.0), 0.0, -0.1),
    ];
    for (percept, closing_m_s, carry) in cases {
        let proposal = bench().evaluate(&percept);
        assert_eq!(proposal.closing_m_s, [closing_m_s; 2].into());
        assert_eq!(proposal.carry_ceiling, carry);
        assert_eq!(proposal.verdict, Verdict::None);
    }
}

#[test]
fn long_backward_motion_is_refused() {
    let mut bench = bench();
    let proposal = bench.evaluate_for(240, &with_utilisation(4.5, 1.0));
    assert_eq!(proposal.verdict, Verdict::None);
    let proposal = bench.evaluate_for(20, &with_utilisation(4.5, 1.0));
    let Verdict::Refuse(reason) = proposal.verdict else {
        panic!("{proposal:?}")
    };
    let record = ReasonRecord::from(reason);
    assert_eq!(record.module, ModuleId::BEHAVIOUR_TABLE);
}

#[test]
fn module_without_table_proposes_nothing() {
    let mut bench = Bench::new(ModuleId::BEHAVIOUR_TABLE);
    let proposal = bench.evaluate(&with_utilisation(4.5, 1.0));
    assert_eq!(proposal, atas_core::modules::Proposal::default());
}

#[test]
fn invalid_table_is_rejected_with_its_fault() {
    let rows = |count: usize| vec![[0, 0]; count].into_iter();
    let check = |bits: &[SensorBit], fingers: &[f64], hand: &[f64], count, fault: TableError| {
        let found = BehaviourTable::validated(bits, fingers, hand, rows(count));
        assert_eq!(found, Err(fault));
    };
    check(&[], &FINGERS, &HAND, 1, TableError::BitCount(0));
    check(
        &[SensorBit(99)],
        &FINGERS,
        &HAND,
        2,
        TableError::UnknownBit(99),
    );
    check(
        &[SensorBit::NONE],
        &FINGERS,
        &HAND,
        2,
        TableError::UnknownBit(0),
    );
    check(
        &[BITS[0]; 2],
        &FINGERS,
        &HAND,
        4,
        TableError::DuplicateBit(BITS[0]),
    );
    check(&BITS, &FINGERS, &HAND, 3, TableError::RowCount(3, 4));
    check(
        &BITS,
        &FINGERS[..3],
        &HAND,
        4,
        TableError::LevelCount("fingers_m_s", 3),
    );
    check(
        &BITS,
        &[0.5],
        &HAND,
        4,
        TableError::LevelRange("fingers_m_s", 0.5, 0.02),
    );
    check(
        &BITS,
        &FINGERS,
        &[-1.5],
        4,
        TableError::LevelRange("hand", -1.5, 1.0),
    );
    let nan = BehaviourTable::validated(&BITS, &FINGERS, &[f64::NAN], rows(4));
    assert!(matches!(nan, Err(TableError::LevelRange("hand", ..))));
    let level = BehaviourTable::validated(&BITS, &FINGERS, &HAND[..2], [[0, 2]; 4].into_iter());
    assert_eq!(level, Err(TableError::UnknownLevel(0)));
}

#[test]
fn table_requires_a_step_that_reads_it() {
    let lift = Step {
        modules: atas_core::modules::Selection::from_modules(&[
            ModuleId::CARRY,
            ModuleId::FORCE_LIMIT,
            ModuleId::BEHAVIOUR_TABLE,
        ]),
        ..GRASP.acting[5]
    };
    let rule = |steps: &[Step], table| {
        Task::validated_with_table("own", steps, None, table).map_err(|fault| fault.rule)
    };
    assert!(
        rule(&[lift], Some(table())).is_ok(),
        "a table is allowed in a moving step"
    );
    assert_eq!(rule(&[lift], None), Err(Rule::NoTable));
    assert_eq!(rule(&GRASP.acting, Some(table())), Err(Rule::UnreadTable));
    let alone = Step {
        modules: atas_core::modules::Selection::from_modules(&[
            ModuleId::CARRY,
            ModuleId::BEHAVIOUR_TABLE,
        ]),
        ..lift
    };
    assert_eq!(rule(&[alone], Some(table())), Err(Rule::NoForceLimit));
}

proptest! {
    #[test]
    fn recorded_table_round_trips_and_damage_is_detected(
        levels in prop::collection::vec((0_usize..4, 0_usize..4), 64),
        count in 1_usize..=6,
        damaged in 0_usize..64,
    ) {
        let bits: Vec<SensorBit> = (1..=count as u32).map(SensorBit).collect();
        let rows: Vec<[usize; 2]> = levels[..1 << count].iter().map(|(a, b)| [*a, *b]).collect();
        let table = BehaviourTable::validated(&bits, &FINGERS, &HAND, rows.iter().copied()).unwrap();
        for (row, levels) in rows.iter().enumerate() {
            prop_assert_eq!(table.levels(row), *levels);
        }
        let mut record = table.record();
        prop_assert_eq!(BehaviourTable::from_record(&record), Ok(Some(table)));
        record.rows[damaged / 16] ^= 1 << damaged;
        prop_assert!(BehaviourTable::from_record(&record).is_err());
    }
}
