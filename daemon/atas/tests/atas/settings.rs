//! Settings: one table, ranges enforced everywhere.

use atas_core::Settings;
use atas_core::settings::{PARAMETERS, Parameter, SettingError, find};
use std::collections::HashSet;

#[test]
fn defaults_are_within_their_ranges() {
    assert_eq!(Settings::default().check(), Ok(()));
    for p in PARAMETERS {
        assert!(p.lower < p.upper, "{}", p.name);
        assert_eq!((p.get)(&Settings::default()), p.default, "{}", p.name);
        assert_eq!(p.check(p.default), Ok(()), "{}", p.name);
    }
}

#[test]
fn parameter_names_are_unique_and_documented() {
    let names: HashSet<_> = PARAMETERS.iter().map(|p| p.name).collect();
    assert_eq!(names.len(), PARAMETERS.len());
    for p in PARAMETERS {
        assert!(
            p.name
                .split_once('.')
                .is_some_and(|(section, key)| !section.is_empty() && !key.is_empty())
        );
        assert!(p.doc.trim().ends_with('.'), "{} needs a sentence", p.name);
        assert_eq!(find(p.name).map(|f| f.name), Some(p.name));
    }
}

/// Value near the default, which contradicts no other default.
fn nudged(p: &Parameter) -> f64 {
    let more = p.default + 1e-3 * (p.default - p.lower).abs().max(1e-6);
    if more <= p.upper { more } else { p.lower }
}

#[test]
fn setting_a_parameter_changes_no_other() {
    for p in PARAMETERS {
        let mut settings = Settings::default();
        let value = nudged(p);
        settings.set(p.name, value).unwrap();
        for other in PARAMETERS {
            let expected = if other.name == p.name {
                value
            } else {
                other.default
            };
            assert_eq!(
                (other.get)(&settings),
                expected,
                "{} after setting {}",
                other.name,
                p.name
            );
        }
        assert_eq!(settings.check(), Ok(()));
    }
}

#[test]
fn invalid_values_have_no_effect() {
    for p in PARAMETERS {
        let mut settings = Settings::default();
        let (below, above) = (p.lower - 1e-3 - p.lower.abs(), p.upper * 1.01 + 1e-3);
        for value in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, below, above] {
            let Err(SettingError::OutOfRange {
                name, lower, upper, ..
            }) = settings.set(p.name, value)
            else {
                panic!("{} took {value}", p.name);
            };
            assert_eq!((name, lower, upper), (p.name, p.lower, p.upper));
            assert_eq!(settings, Settings::default());
        }
        for value in [p.lower, p.upper] {
            let set = settings.set(p.name, value);
            assert!(
                matches!(set, Ok(()) | Err(SettingError::Contradiction { .. })),
                "{}",
                p.name
            );
            settings = Settings::default();
        }
    }
    let mut settings = Settings::default();
    for name in [
        "",
        "grasp",
        "grasp.",
        "approach_m_s",
        "grasp.approach_m_s ",
        "Grasp.approach_m_s",
    ] {
        assert_eq!(
            settings.set(name, 0.002),
            Err(SettingError::Unknown),
            "{name:?}"
        );
    }
}

#[test]
fn check_finds_every_invalid_field() {
    let mut settings = Settings::default();
    settings.motion.open_m_s = f64::NAN;
    let error = settings.check().unwrap_err();
    assert_eq!(
        error.to_string(),
        "motion.open_m_s is NaN, needs a number from 0.001 to 0.07"
    );
}

#[test]
fn contradicting_values_are_rejected() {
    let default = Settings::default();
    for (name, value, other, way_out) in [
        ("intake.hold_age_s", 0.2, "intake.reject_age_s", 0.3),
        ("perception.touch_off_n", 0.07, "perception.touch_on_n", 0.1),
        (
            "perception.touch_on_n",
            0.02,
            "perception.touch_off_n",
            0.01,
        ),
        ("grasp.carry_min_n", 0.5, "grasp.f1_min_n", 0.6),
        ("grasp.f1_min_n", 1.5, "grasp.f1_max_n", 2.0),
        ("grasp.f2_min_n", 9.0, "grasp.f2_max_n", 10.0),
        ("grasp.f2_max_n", 20.0, "safety.grip_ceiling_n", 30.0),
        ("grasp.slip_off", 0.93, "grasp.slip_on", 0.95),
        ("grasp.relax_below", 0.93, "grasp.slip_on", 0.95),
    ] {
        let mut settings = default;
        let refused = settings.set(name, value).unwrap_err().to_string();
        assert!(
            refused.contains(name) && refused.contains(other),
            "{refused}"
        );
        assert_eq!(settings, default, "{name}");
        settings.set(other, way_out).unwrap();
        settings.set(name, value).unwrap();
        assert_eq!(settings.check(), Ok(()), "{name}");
    }
    let mut settings = default;
    settings.grasp.f2_min_n = 9.0;
    assert_eq!(
        settings.check().unwrap_err().to_string(),
        "grasp.f2_min_n is 9, needs at most grasp.f2_max_n, which is 8; change the other parameter \
         first"
    );
}

#[cfg(feature = "serde")]
#[test]
fn settings_round_trip_through_a_configuration_file() {
    let mut settings = Settings::default();
    for p in PARAMETERS {
        settings.set(p.name, nudged(p)).unwrap();
    }
    let text = toml::to_string(&settings).unwrap();
    assert_eq!(toml::from_str::<Settings>(&text).unwrap(), settings);
    assert_eq!(toml::from_str::<Settings>("").unwrap(), Settings::default());
    let partial = toml::from_str::<Settings>("[grasp]\ndr_n = 0.07\n").unwrap();
    assert_eq!(
        (partial.grasp.dr_n, partial.motion),
        (0.07, Settings::default().motion)
    );
    for wrong in [
        "[grasp]\ndr = 1.0\n",
        "[grip]\n",
        "[grasp]\ndr_n = \"high\"\n",
    ] {
        assert!(toml::from_str::<Settings>(wrong).is_err(), "{wrong}");
    }
}
