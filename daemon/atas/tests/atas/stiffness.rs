//! The stiffness fit on synthetic series of closing and force.

use atas_core::perception::{StiffnessEstimate, StiffnessFit};
use atas_core::settings::{Perception as Settings, Settings as All};
use robot_model::{Compression, Skin};

const TIPS: Compression = Skin::DOME_41.compression;

/// The law that the fit is made for: x = 2·(a·F^p + F/k).
fn closing_m(normal_n: f64, object_n_m: f64) -> f64 {
    let Compression { at_1n_m, exponent } = TIPS;
    2.0 * (at_1n_m * normal_n.powf(exponent) + normal_n / object_n_m)
}

/// A series of 100 frames from one force to another, with an offset of the closing and alternating noise, m.
fn probed(
    object_n_m: f64,
    (from_n, to_n): (f64, f64),
    noise_m: f64,
    filter_s: f64,
) -> Option<StiffnessFit> {
    let settings = Settings {
        filter_s,
        ..All::default().perception
    };
    let mut estimate = StiffnessEstimate::default();
    let mut fit = None;
    let mut felt_n = from_n;
    for i in 0..100 {
        let true_n = from_n + (to_n - from_n) * f64::from(i) / 99.0;
        felt_n += (true_n - felt_n)
            * if filter_s > 0.0 {
                1e-3 / (filter_s + 1e-3)
            } else {
                1.0
            };
        let noise_m = if i % 2 == 0 { noise_m } else { -noise_m };
        let closed_m = closing_m(true_n, object_n_m) - 1e-4 + noise_m;
        fit = estimate
            .add(closed_m, felt_n, 1e-3, &TIPS, &settings)
            .or(fit);
    }
    fit
}

#[test]
fn a_known_stiffness_is_recovered_whatever_the_starting_force() {
    for object_n_m in [300.0, 700.0, 1500.0, 3000.0, 6000.0, 12_000.0] {
        for forces_n in [(0.06, 0.3), (0.06, 1.0), (0.3, 0.8), (1.0, 2.0)] {
            let fit = probed(object_n_m, forces_n, 0.0, 0.0).unwrap();
            assert!(
                (fit.object_n_m / object_n_m - 1.0).abs() < 1e-6,
                "{object_n_m} N/m over {forces_n:?}: {fit:?}"
            );
            assert!(fit.confidence > 0.999, "{fit:?}");
        }
    }
}

#[test]
fn the_forces_low_pass_does_not_shift_the_fit() {
    for object_n_m in [300.0, 1500.0, 6000.0] {
        let fit = probed(object_n_m, (0.1, 1.0), 0.0, 0.005).unwrap();
        assert!(
            (fit.object_n_m / object_n_m - 1.0).abs() < 0.1,
            "{object_n_m} N/m: {fit:?}"
        );
    }
}

#[test]
fn noise_costs_confidence() {
    let fits =
        [0.0, 2e-6, 2e-5, 2e-4].map(|noise_m| probed(6000.0, (0.1, 0.5), noise_m, 0.0).unwrap());
    assert!(
        fits.is_sorted_by(|a, b| a.confidence > b.confidence),
        "{fits:?}"
    );
    assert!(
        fits.iter()
            .all(|f| f.object_n_m > 0.0 && (0.0..=1.0).contains(&f.confidence)),
        "{fits:?}"
    );
    assert!(fits[3].confidence < 0.8, "{fits:?}");
}

#[test]
fn a_rigid_block_reads_as_very_stiff_and_never_as_negative() {
    let fit = probed(1e12, (0.1, 1.0), 0.0, 0.0).unwrap();
    assert!(fit.object_n_m >= 0.9e6, "{fit:?}");
    // Closing that even shrinks while the force grows.
    let settings = Settings {
        filter_s: 0.0,
        ..All::default().perception
    };
    let mut estimate = StiffnessEstimate::default();
    let fit = (1..20).fold(None, |fit, i| {
        estimate
            .add(
                -1e-4 * f64::from(i),
                0.1 * f64::from(i),
                1e-3,
                &TIPS,
                &settings,
            )
            .or(fit)
    });
    assert!(
        fit.is_some_and(|f| f.object_n_m.is_finite() && f.object_n_m > 0.0),
        "{fit:?}"
    );
}

#[test]
fn no_news_gives_no_fit() {
    let settings = All::default().perception;
    let mut estimate = StiffnessEstimate::default();
    // Too light to be a touch, then one force for ever, then less than before.
    for (closing_m, normal_n) in [
        (0.0, 0.0),
        (1e-4, 0.02),
        (2e-4, 0.5),
        (3e-4, 0.5),
        (4e-4, 0.5),
        (5e-4, 0.4),
    ] {
        assert_eq!(
            estimate.add(closing_m, normal_n, 1e-3, &TIPS, &settings),
            None,
            "at {normal_n} N"
        );
    }
    assert_eq!(
        estimate.add(f64::NAN, f64::NAN, 1e-3, &TIPS, &settings),
        None
    );
}
