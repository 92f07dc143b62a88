//! Tests of the weight estimate.

use super::*;

/// Regression: the weight of a bottle that slid out within two seconds fell too slowly to be
/// detected.
#[test]
fn gradual_weight_loss_within_seconds_is_detected() {
    let lost_after_ticks = |lighter_n_s: f64| {
        let mut weight = Weight::default();
        (0..5000).position(|tick| {
            let down_n = 5.0 - lighter_n_s * 1e-3 * f64::from(tick);
            weight.update(down_n.max(0.5), false, 1e-3);
            weight.loss().is_some()
        })
    };
    assert!(lost_after_ticks(2.0).is_some(), "5 N lost by sliding out");
    assert_eq!(lost_after_ticks(0.5), None, "half of the weight poured out");
}

/// Regression: a bottle slid slowly through the fingers down to the table, with uniform shear
/// and without a sudden drop; the task succeeded.
#[test]
fn object_that_slides_to_its_support_is_not_carried() {
    for (remaining, is_carried) in [(1.0, true), (0.9, true), (0.4, false)] {
        let mut weight = Weight::default();
        for tick in 0..5000 {
            let share = (f64::from(tick - 1000) / 1000.0).clamp(0.0, 1.0);
            let down_n = 5.0 - 5.0 * (1.0 - remaining) * share;
            weight.update(down_n, false, 1e-3);
        }
        let reason = weight.lightening();
        assert_eq!(reason.is_none(), is_carried, "{remaining} of the weight");
    }
}

#[test]
fn standing_object_slips_by_the_hand_travel() {
    let mut weight = Weight::default();
    for (carried_m, fails) in [(0.002, false), (0.0025, false), (0.003, true)] {
        weight.stands(carried_m);
        assert_eq!(weight.slip().is_some(), fails, "{carried_m} m");
    }
}

/// Weight of 5 N with a scatter of 0.2 N.
fn known() -> Weight {
    Weight {
        weight_n: 5.0,
        weighed_s: 1.0,
        scatter_n2: 0.04,
        ..Weight::default()
    }
}

#[test]
fn weight_is_the_mean_of_the_first_loads() {
    let mut weight = Weight::default();
    for (down_n, mean_n) in [(-1.0, 0.0), (4.0, 4.0), (6.0, 5.0), (8.0, 6.0), (2.0, 5.0)] {
        weight.update(down_n, false, 0.01);
        assert!((weight.weight_n - mean_n).abs() < 1e-12, "{weight:?}");
    }
    // Squared deviations from the mean before: 2², 3², 4², averaged in the same way.
    let scatter_n2 = (4.0 / 2.0 * 2.0 / 3.0 + 9.0 / 3.0) * 3.0 / 4.0 + 16.0 / 4.0;
    assert!((weight.scatter_n2 - scatter_n2).abs() < 1e-12, "{weight:?}");
}

#[test]
fn missing_load_accelerates_the_object() {
    for (drops, speed_m_s, down_n, after_m_s, slip_m) in [
        (false, 0.0, 4.0, 0.0, 0.0),
        (true, 0.0, 4.0, 9.81 * 0.16 * 0.01, 9.81 * 0.16 * 1e-4),
        (
            false,
            0.5,
            4.0,
            0.5 + 9.81 * 0.16 * 0.01,
            0.005 + 9.81 * 0.16 * 1e-4,
        ),
        (
            true,
            0.5,
            6.0,
            0.5 - 9.81 * 0.24 * 0.01,
            0.005 - 9.81 * 0.24 * 1e-4,
        ),
        (true, 0.001, 9.0, 0.0, 0.0),
    ] {
        let mut weight = Weight {
            slip_m_s: speed_m_s,
            ..known()
        };
        weight.update(down_n, drops, 0.01);
        assert!((weight.slip_m_s - after_m_s).abs() < 1e-12, "{weight:?}");
        assert!((weight.slip_m - slip_m).abs() < 1e-12, "{weight:?}");
        assert_eq!(
            weight.weight_n == 5.0,
            drops || speed_m_s > 0.0,
            "{weight:?}"
        );
    }
}

#[test]
fn object_is_lost_below_its_share_of_the_weight() {
    for (down_n, loss) in [
        (1.6, false),
        (1.5, false),
        (1.4, true),
        (-1.4, true),
        (-1.6, false),
    ] {
        let mut weight = known();
        let reason = Reason::LostObject {
            force_n: 1.4,
            limit_n: 1.5,
        };
        for is_late in [false, false, true] {
            weight.update(down_n, true, 0.1);
            let expected = (loss && is_late).then_some(reason);
            assert_eq!(weight.loss(), expected, "{down_n} N");
        }
    }
}

#[test]
fn reasons_need_more_than_their_limits() {
    let least_n = CARRIED_SHARE * 4.0 - libm::sqrt(0.01);
    for (weight_n, is_light) in [(least_n, false), (least_n.next_down(), true), (3.2, true)] {
        let weight = Weight {
            weight_n,
            max_n: 4.0,
            scatter_n2: 0.01,
            ..Weight::default()
        };
        let reason = Reason::LostObject {
            force_n: weight_n,
            limit_n: least_n,
        };
        assert_eq!(weight.lightening(), is_light.then_some(reason));
    }
    for (slip_m, has_slipped) in [(SLIP_MAX_M, false), (0.003, true)] {
        let weight = Weight {
            slip_m,
            ..Weight::default()
        };
        let reason = Reason::SlippedInHand {
            slip_m,
            limit_m: SLIP_MAX_M,
        };
        assert_eq!(weight.slip(), has_slipped.then_some(reason));
    }
}
