//! Tests of the reflex evaluation: results independent of threads, and the JSON fields that scripts
//! use.

use std::sync::atomic::AtomicBool;

use atas_evaluation::{ReflexPlan, ReflexReport};

fn run(trials: u64, threads: usize) -> ReflexReport {
    let plan = ReflexPlan {
        trials,
        first_seed: 1,
        threads,
        settings: atas_core::Settings::default(),
    };
    let report = plan.run(&AtomicBool::new(false), || ());
    report.expect("it runs").expect("nobody stopped it")
}

#[test]
fn a_clumsy_policy_holds_with_the_reflex_and_not_without() {
    let report = run(6, 0);
    assert_eq!(report, run(6, 1), "whatever the number of threads");
    assert_eq!(report.with.crushed, 0, "{report:?}");
    assert!(report.with.success > report.without.success, "{report:?}");
    let told = serde_json::to_value(&report).expect("JSON");
    assert_eq!(told["purpose"], "tuning");
    for side in ["with", "without"] {
        for field in ["trials", "success", "crushed"] {
            assert!(told[side][field].is_number(), "{side}.{field}: {told}");
        }
    }
    let slip = &report.slip_to_command_ms;
    assert!(slip.p99.is_some_and(|ms| ms <= 15.0), "{slip:?}");
    assert!(slip.p99_with_f2 >= slip.p99, "{slip:?}");
    for field in ["count", "p50", "p99", "p99_with_f2"] {
        assert!(
            told["slip_to_command_ms"][field].is_number(),
            "{field}: {told}"
        );
    }
}
