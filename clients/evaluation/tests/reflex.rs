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
    report.expect("it runs").expect("not stopped")
}

#[test]
fn reflex_improves_a_coarse_policy() {
    let report = run(6, 0);
    assert_eq!(report, run(6, 1), "independent of the number of threads");
    assert_eq!(report.with.crushed, 0, "{report:?}");
    assert!(report.with.success > report.without.success, "{report:?}");
    let output = serde_json::to_value(&report).expect("JSON");
    assert_eq!(output["purpose"], "tuning");
    for side in ["with", "without"] {
        for field in ["trials", "success", "crushed"] {
            assert!(output[side][field].is_number(), "{side}.{field}: {output}");
        }
    }
    let slip = &report.slip_to_command_ms;
    assert!(slip.p99.is_some_and(|ms| ms <= 15.0), "{slip:?}");
    assert!(slip.p99_with_f2 >= slip.p99, "{slip:?}");
    for field in ["count", "p50", "p99", "p99_with_f2"] {
        assert!(
            output["slip_to_command_ms"][field].is_number(),
            "{field}: {output}"
        );
    }
}
