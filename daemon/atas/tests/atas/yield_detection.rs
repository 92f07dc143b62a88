//! Yield detection.

use atas_core::perception::{PressMaxima, YieldDetector, YieldRule};
use proptest::prelude::*;

/// Force ramp of 1 N/s at 100 frames per second on an object with this compliance, m/N, as a
/// function of force.
fn pressed(to_n: f64, compliance_m_n: impl Fn(f64) -> f64) -> (YieldDetector, Option<PressMaxima>) {
    let mut watch = YieldDetector::new(YieldRule::default());
    let mut closing_m = 0.03;
    let mut yielded = None;
    for frame in 0..(to_n * 100.0) as u32 {
        let force_n = f64::from(frame) * 0.01;
        closing_m += 0.01 * compliance_m_n(force_n);
        yielded = watch.add(closing_m, force_n);
        if yielded.is_some() {
            break;
        }
    }
    (watch, yielded)
}

#[test]
fn softening_to_a_fifth_is_detected() {
    for at_n in [3.0, 7.0, 12.0] {
        let flesh = |force_n: f64| if force_n < at_n { 2.5e-4 } else { 2.0e-3 };
        let (_, yielded) = pressed(16.0, flesh);
        let yielded = yielded.expect("the object ruptures");
        // Detected after most of the last newton was soft.
        assert!(
            (at_n..at_n + 0.5).contains(&yielded.peak_n),
            "{at_n} N: {yielded:?}"
        );
        assert!(
            (yielded.max_stiffness_n_m - 4000.0).abs() < 200.0,
            "{yielded:?}"
        );
    }
}

#[test]
fn constant_or_rising_stiffness_is_not_yielding() {
    let check = |compliance_m_n: fn(f64) -> f64| {
        let (watch, yielded) = pressed(16.0, compliance_m_n);
        assert_eq!(yielded, None);
        assert!(watch.maxima().peak_n > 15.9);
    };
    check(|_| 2.5e-4);
    check(|force_n| 1e-3 / (1.0 + force_n));
    // A skin with doubled stiffness in the middle.
    check(|force_n| {
        if (4.0..6.0).contains(&force_n) {
            2e-4
        } else {
            4e-4
        }
    });
}

/// Regression: a force jump beyond the window looked like an infinitely stiff object that yields at
/// once.
#[test]
fn force_jump_is_ignored() {
    let mut watch = YieldDetector::new(YieldRule::default());
    for frame in 0..400 {
        let jump_n = if frame < 200 { 0.0 } else { 5.0 };
        let force_n = 0.5 + 0.01 * f64::from(frame) + jump_n;
        assert_eq!(
            watch.add(2.5e-6 * f64::from(frame), force_n),
            None,
            "{frame}"
        );
    }
}

proptest! {
    #[test]
    fn any_series_causes_no_panic(series in prop::collection::vec((any::<f64>(), any::<f64>()), 0..300)) {
        let mut watch = YieldDetector::new(YieldRule::default());
        for (closing_m, force_n) in series {
            let _ = watch.add(closing_m, force_n);
            let tolerated = watch.maxima();
            prop_assert!(tolerated.peak_n >= 0.0 && !tolerated.max_stiffness_n_m.is_nan());
        }
    }
}
