//! Comparison of a sensor model with the domain of validity of the controller
//! (`atas calibrate model --check-domain`).
//!
//! `domain.toml` is the result of `python -m atas.sensitivity one-at-a-time`: for each parameter
//! the largest deviation at which grasps still succeed, with all other parameters nominal.

use anyhow::Context;
use serde::{Deserialize, Serialize};
use sim_backend::SensorModel;

/// Domain of validity, measured on the built-in engine with the layout [`LAYOUT`].
const DOMAIN: &str = include_str!("domain.toml");

/// Layout of the fingertips with which the domain was measured.
pub(super) const LAYOUT: &str = "dome-41";

#[derive(Deserialize)]
struct Domain {
    parameter: Vec<Parameter>,
}

#[derive(Deserialize)]
struct Parameter {
    name: String,
    unit: String,
    low: Option<f64>,
    high: Option<f64>,
    low_failure: Option<String>,
    high_failure: Option<String>,
    model_key: Option<String>,
    model_factor: Option<f64>,
}

/// One property of a sensor model beside its valid range.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(super) struct Checked {
    /// Name of the parameter in the sensitivity analysis.
    pub(super) name: String,
    /// Unit of all values.
    pub(super) unit: String,
    /// Value of the model.
    pub(super) value: f64,
    /// Least valid value; `None`: not limited.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) low: Option<f64>,
    /// Largest valid value; `None`: not limited.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) high: Option<f64>,
    /// True if the value is within the range.
    pub(super) valid: bool,
    /// Most frequent failure beyond the violated limit, if it was observed.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) failure: Option<String>,
}

/// Compares the properties that the model has with the domain of validity.
///
/// # Errors
/// The model has no text form.
pub(super) fn check(model: &SensorModel) -> anyhow::Result<Vec<Checked>> {
    let domain: Domain = toml::from_str(DOMAIN).context("could not read the domain of validity")?;
    let model: toml::Table = toml::from_str(&model.to_toml()?)?;
    let parameters = domain.parameter.into_iter();
    Ok(parameters.filter_map(|it| it.check(&model)).collect())
}

impl Parameter {
    /// Returns the comparison; `None` if the model lacks this property.
    fn check(self, model: &toml::Table) -> Option<Checked> {
        let (key, factor) = (self.model_key?, self.model_factor?);
        let values = numbers(model, &key)?.map(|value| factor * value.abs());
        // Of several values the worst counts: the least, if the parameter has no upper limit.
        let value = match self.high {
            Some(_) => values.fold(0.0, f64::max),
            None => values.fold(f64::INFINITY, f64::min),
        };
        let (is_low, is_high) = (
            self.low.is_some_and(|low| value < low),
            self.high.is_some_and(|high| value > high),
        );
        Some(Checked {
            name: self.name,
            unit: self.unit,
            value,
            low: self.low,
            high: self.high,
            valid: !is_low && !is_high,
            failure: match (is_low, is_high) {
                (true, _) => self.low_failure,
                (_, true) => self.high_failure,
                _ => None,
            },
        })
    }
}

/// Returns the numbers under a dotted key; `None` if the key is absent or has no number.
fn numbers(table: &toml::Table, key: &str) -> Option<impl Iterator<Item = f64>> {
    let mut words = key.split('.');
    let first = table.get(words.next()?)?;
    let value = words.try_fold(first, |value, word| value.get(word))?;
    let values = match value {
        toml::Value::Array(values) => values.clone(),
        value => vec![value.clone()],
    };
    let number = |value: &toml::Value| value.as_float().or(value.as_integer().map(|it| it as f64));
    let numbers: Vec<f64> = values.iter().filter_map(number).collect();
    (!numbers.is_empty()).then(|| numbers.into_iter())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn checked(name: &str, text: &str) -> Option<Checked> {
        let parameter = Parameter {
            name: name.to_owned(),
            unit: "N".to_owned(),
            low: (name == "saturation").then_some(1.5),
            high: (name != "saturation").then_some(0.05),
            low_failure: Some("too low".to_owned()),
            high_failure: Some("too high".to_owned()),
            model_key: Some("part.value".to_owned()),
            model_factor: Some(2.0),
        };
        parameter.check(&toml::from_str(text).expect("valid"))
    }

    #[test]
    fn worst_value_is_compared_with_the_limits() {
        let valid = |name, text: &str| checked(name, text).map(|it| (it.value, it.valid));
        assert_eq!(
            valid("drift", "[part]\nvalue = [0.01, -0.02, 0.0]"),
            Some((0.04, true))
        );
        assert_eq!(valid("drift", "[part]\nvalue = -0.03"), Some((0.06, false)));
        assert_eq!(
            valid("saturation", "[part]\nvalue = [1, 4]"),
            Some((2.0, true))
        );
        assert_eq!(
            valid("saturation", "[part]\nvalue = [0.5, 4.0]"),
            Some((1.0, false))
        );
        assert_eq!(valid("drift", "[part]\nother = 1.0"), None);
        assert_eq!(valid("drift", "other = 1.0"), None);
        let low = checked("saturation", "[part]\nvalue = 0.5").and_then(|it| it.failure);
        assert_eq!(low.as_deref(), Some("too low"));
    }

    #[test]
    fn every_preset_has_comparable_properties() {
        for name in SensorModel::names() {
            let model = SensorModel::from_name_or_file(name).expect(name);
            let checked = check(&model).expect(name);
            assert!(
                checked.iter().any(|it| it.name == "noise"),
                "{name}: {checked:?}"
            );
            assert!(
                checked.iter().all(|it| it.value.is_finite()),
                "{name}: {checked:?}"
            );
        }
    }

    #[test]
    fn design_is_valid_and_a_drifting_sensor_is_not() {
        let design = check(&SensorModel::default()).expect("readable");
        assert!(design.iter().all(|it| it.valid), "{design:?}");
        let drifting: SensorModel = SensorModel {
            noise_n: [0.5, 0.5],
            ..SensorModel::default()
        };
        let checked = check(&drifting).expect("readable");
        assert!(checked.iter().any(|it| it.name == "noise" && !it.valid));
    }
}
