//! Slip reaction: the baseline for modules 1 to 3.

use crate::bench::{Bench, pressed, with_utilisation};
use robot_model::GraspSide;
use shm_schemas::ModuleId;

/// F_1 on the bench, N: initial force target.
const START_N: f64 = 0.5;

/// Force target after this slip duration, N: force at which the module stops closing.
fn target_n(slipping_ms: usize) -> f64 {
    let mut bench = Bench::new(ModuleId::SLIP_REACTION);
    for _ in 0..slipping_ms {
        bench.evaluate(&with_utilisation(2.0, 1.0));
    }
    let mut force_n = 0.0;
    while bench.evaluate(&pressed(force_n)).active {
        force_n += 1e-4;
    }
    force_n
}

#[test]
fn target_rises_8_percent_per_41_ms_slip() {
    let check = |slipping_ms, raises| {
        let expected_n = START_N * 1.08_f64.powi(raises);
        let target_n = target_n(slipping_ms);
        assert!(
            (target_n - expected_n).abs() < 2e-4,
            "{target_n} N after {slipping_ms} ms, expected {expected_n} N"
        );
    };
    check(0, 0);
    check(40, 0);
    check(41, 1);
    check(410, 10);
    check(1230, 30);
}

#[test]
fn slip_reaction_never_opens_or_limits_approach() {
    let mut bench = Bench::new(ModuleId::SLIP_REACTION);
    let proposal = bench.evaluate(&pressed(9.0));
    assert_eq!(
        (proposal.active, proposal.closing_m_s),
        (false, [0.0; 2].into())
    );
    bench.object.all_touched = false;
    let proposal = bench.evaluate_for(100, &with_utilisation(0.3, 1.0));
    assert_eq!(
        (proposal.active, proposal.closing_m_s),
        (false, [0.0; 2].into())
    );
    bench.object.all_touched = true;
    assert!(bench.evaluate(&pressed(0.3)).closing_m_s[GraspSide::First] > 0.0);
}
