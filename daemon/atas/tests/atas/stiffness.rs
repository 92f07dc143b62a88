//! Stiffness fit on synthetic series of closing and force.

use atas_core::perception::{LoadedArea, StiffnessEstimate, StiffnessFit};
use atas_core::settings::{Perception as Settings, Settings as All};
use robot_model::{Compression, Skin};

const TIPS: Compression = Skin::DOME_41.compression;
const WHOLE: [LoadedArea; 2] = [LoadedArea::WHOLE; 2];

/// One fingertip per side with this share of its face in contact.
fn faces(face_share: f64) -> [LoadedArea; 2] {
    [LoadedArea {
        face_share,
        ..LoadedArea::WHOLE
    }; 2]
}

/// Model of the fit: x = 2·(a·F^p + F/k).
fn closing_m(normal_n: f64, object_n_m: f64) -> f64 {
    let Compression { at_1n_m, exponent } = TIPS;
    2.0 * (at_1n_m * normal_n.powf(exponent) + normal_n / object_n_m)
}

/// Series of 100 frames between two forces, with a closing offset and alternating noise, m.
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
            .add(closed_m, felt_n, 1e-3, &TIPS, WHOLE.into(), &settings)
            .or(fit);
    }
    fit
}

#[test]
fn fit_recovers_stiffness_from_any_starting_force() {
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

const FLAT: Compression = Compression {
    at_1n_m: 2e-5,
    exponent: 1.0,
};

fn unfiltered() -> Settings {
    Settings {
        filter_s: 0.0,
        ..All::default().perception
    }
}

/// The contact share grows with the force.
#[test]
fn edge_contact_does_not_bias_the_stiffness() {
    const ALL_PRESS_N: f64 = 0.6;
    let settings = unfiltered();
    let fitted = |object_n_m: f64, uses_shares: bool| {
        let (mut estimate, mut fit, mut tips_m) = (StiffnessEstimate::default(), None, 0.0);
        for i in 50..1000_u32 {
            let normal_n = 1e-3 * f64::from(i);
            let share = (normal_n / ALL_PRESS_N).min(1.0);
            tips_m += 1e-3 * FLAT.at_1n_m / share;
            let closing_m = 2.0 * (tips_m + normal_n / object_n_m);
            let output = if uses_shares { faces(share) } else { WHOLE };
            fit = estimate
                .add(closing_m, normal_n, 1e-3, &FLAT, output.into(), &settings)
                .or(fit);
        }
        fit.unwrap().object_n_m
    };
    for object_n_m in [1500.0, 6000.0, 30_000.0, 1e9] {
        let ratio = fitted(object_n_m, true) / object_n_m.min(1e6);
        assert!((ratio - 1.0).abs() < 1e-3, "{object_n_m} N/m: {ratio}");
    }
    let taken_for_n_m = fitted(1e9, false);
    assert!(
        taken_for_n_m < 1e5,
        "estimate without the correction: {taken_for_n_m}"
    );
}

/// An object between the edges of two pads rotates until it aligns, which closes the fingers. The
/// previous estimate is discarded once the new contact gives data.
#[test]
fn rotating_object_is_not_estimated_soft() {
    let settings = unfiltered();
    for object_n_m in [1500.0, 30_000.0] {
        let (mut estimate, mut fits, mut turned_m) = (StiffnessEstimate::default(), vec![], 0.0);
        for i in 50..600_u32 {
            let (normal_n, lies) = (1e-3 * f64::from(i), i >= 300);
            let share = if lies { 0.9 } else { 0.3 };
            turned_m += if lies { 0.0 } else { 4e-6 };
            let closing_m = turned_m + 2.0 * normal_n * (FLAT.at_1n_m / share + 1.0 / object_n_m);
            fits.push(estimate.add(
                closing_m,
                normal_n,
                1e-3,
                &FLAT,
                faces(share).into(),
                &settings,
            ));
        }
        let read_n_m = |at: usize| fits[at - 50].map(|fit| fit.object_n_m);
        let turning_n_m = read_n_m(299).unwrap();
        assert!(turning_n_m < 0.55 * object_n_m, "{turning_n_m}");
        assert_eq!(read_n_m(304), None, "five samples are too few");
        let ratio = read_n_m(599).unwrap() / object_n_m;
        assert!((ratio - 1.0).abs() < 0.02, "{object_n_m} N/m: {ratio}");
    }
}

/// Regression: a rigid object's stiffness never reaches 10 % accuracy, so the estimate from the
/// rotation was kept.
#[test]
fn rotated_rigid_object_is_estimated_stiffer() {
    let settings = unfiltered();
    let (mut estimate, mut fit, mut noise) = (StiffnessEstimate::default(), None, 1_u32);
    for i in 50..600_u32 {
        let (normal_n, lies) = (1e-3 * f64::from(i), i >= 300);
        let tips = if lies { 2.0 } else { 1.0 };
        let bearing = [
            LoadedArea {
                fingertips: tips,
                ..LoadedArea::WHOLE
            },
            LoadedArea::WHOLE,
        ];
        noise = noise.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        let noise_m = 4e-6 * (f64::from(noise >> 16) / 65_536.0 - 0.5);
        let turned_m = 1e-6 * f64::from(i.min(300));
        let closing_m = turned_m + normal_n * FLAT.at_1n_m * (1.0 / tips + 1.0) + noise_m;
        let news = estimate.add(closing_m, normal_n, 1e-3, &FLAT, bearing.into(), &settings);
        fit = news.or(fit);
        if i == 299 {
            assert!(fit.is_some_and(|fit| fit.object_n_m < 3000.0), "{fit:?}");
            assert!(!estimate.has_new_contact());
        }
    }
    assert!(estimate.has_new_contact());
    assert!(fit.is_some_and(|fit| fit.object_n_m > 100_000.0), "{fit:?}");
}

#[test]
fn force_low_pass_does_not_bias_the_fit() {
    for object_n_m in [300.0, 1500.0, 6000.0] {
        let fit = probed(object_n_m, (0.1, 1.0), 0.0, 0.005).unwrap();
        assert!(
            (fit.object_n_m / object_n_m - 1.0).abs() < 0.1,
            "{object_n_m} N/m: {fit:?}"
        );
    }
}

#[test]
fn noise_reduces_confidence() {
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
fn rigid_block_is_stiff_and_never_negative() {
    let fit = probed(1e12, (0.1, 1.0), 0.0, 0.0).unwrap();
    assert!(fit.object_n_m >= 0.9e6, "{fit:?}");
    // Closing that decreases while the force grows.
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
                WHOLE.into(),
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
fn series_without_new_data_gives_no_fit() {
    let settings = All::default().perception;
    let mut estimate = StiffnessEstimate::default();
    // Force below contact, then constant, then lower than before.
    for (closing_m, normal_n) in [
        (0.0, 0.0),
        (1e-4, 0.02),
        (2e-4, 0.5),
        (3e-4, 0.5),
        (4e-4, 0.5),
        (5e-4, 0.4),
    ] {
        assert_eq!(
            estimate.add(closing_m, normal_n, 1e-3, &TIPS, WHOLE.into(), &settings),
            None,
            "at {normal_n} N"
        );
    }
    assert_eq!(
        estimate.add(f64::NAN, f64::NAN, 1e-3, &TIPS, WHOLE.into(), &settings),
        None
    );
}
