//! Settings: one table, no way past its ranges.

use atas::Settings;
use atas::settings::{PARAMETERS, SettingError, find};
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
fn the_table_is_unique_and_documented() {
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

#[test]
fn every_parameter_is_set_by_name_and_nothing_else_changes() {
    for p in PARAMETERS {
        let mut settings = Settings::default();
        let value = if p.default == p.upper {
            p.lower
        } else {
            p.upper
        };
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
fn bad_values_change_nothing() {
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
            assert_eq!(settings.set(p.name, value), Ok(()), "{}", p.name);
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
fn a_wrong_field_is_found_wherever_it_is() {
    let mut settings = Settings::default();
    settings.motion.open_m_s = f64::NAN;
    let error = settings.check().unwrap_err();
    assert_eq!(
        error.to_string(),
        "motion.open_m_s is NaN, needs a number from 0.001 to 0.07"
    );
}

#[cfg(feature = "serde")]
#[test]
fn settings_round_trip_through_a_configuration_file() {
    let mut settings = Settings::default();
    for p in PARAMETERS {
        settings
            .set(p.name, p.lower + (p.upper - p.lower) / 3.0)
            .unwrap();
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
