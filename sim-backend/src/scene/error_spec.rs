//! Text format of errors: `crosstalk`, `all`, `position=2,yaw=5`, `all=0.5`.
//!
//! A kind may have an amount, in its own unit; the default is its size in [`Errors::KINDS`],
//! [`Errors::SENSOR_KINDS`] or [`Errors::DRIVE_KINDS`]. `all` sets every kind of the first; its
//! amount is a factor on all sizes. `none` clears all. Commas separate several entries, applied in
//! order.

use core::f64::consts::PI;
use core::str::FromStr;

use super::{ErrorKind, Errors};

/// Text format of one kind of error.
struct Field {
    name: &'static str,
    /// Unit of the amount.
    unit: &'static str,
    /// Factor from this unit to the unit of the field.
    per_unit: f64,
    field: fn(&mut Errors) -> &mut f64,
    /// True for a kind that `all` includes.
    in_all: bool,
}

const fn field_outside_all(
    name: &'static str,
    unit: &'static str,
    per_unit: f64,
    of: fn(&mut Errors) -> &mut f64,
) -> Field {
    Field {
        in_all: false,
        ..field(name, unit, per_unit, of)
    }
}

const fn field(
    name: &'static str,
    unit: &'static str,
    per_unit: f64,
    of: fn(&mut Errors) -> &mut f64,
) -> Field {
    Field {
        name,
        unit,
        per_unit,
        field: of,
        in_all: true,
    }
}

impl Field {
    fn size(&self) -> f64 {
        let mut sizes = Errors::SIZES;
        *(self.field)(&mut sizes)
    }
}

/// Number of kinds.
const KINDS: usize = Errors::KINDS.len() + Errors::SENSOR_KINDS.len() + Errors::DRIVE_KINDS.len();

/// One entry per kind, with the names of [`Errors::KINDS`], [`Errors::SENSOR_KINDS`] and
/// [`Errors::DRIVE_KINDS`].
const FIELDS: [Field; KINDS] = [
    field("servo", "%", 0.01, |e| &mut e.servo_stiffness),
    field("links", "mm", 1e-3, |e| &mut e.link_m),
    field("tips", "%", 0.01, |e| &mut e.tip_stiffness),
    field("crosstalk", "%", 0.01, |e| &mut e.crosstalk),
    field("bias", "mN", 1e-3, |e| &mut e.bias_n),
    field("gain", "%", 0.01, |e| &mut e.gain),
    field("centre-of-mass", "mm", 1e-3, |e| &mut e.centre_of_mass_m),
    field("position", "mm", 1e-3, |e| &mut e.position_m),
    field("yaw", "°", PI / 180.0, |e| &mut e.yaw_rad),
    field("expected-width", "mm", 1e-3, |e| &mut e.expected_width_m),
    field("height", "mm", 1e-3, |e| &mut e.height_m),
    field_outside_all("drift", "N/s", 1.0, |e| &mut e.sensor.drift_n_s),
    field_outside_all("hysteresis", "%", 0.01, |e| &mut e.sensor.hysteresis),
    field_outside_all("creep", "%", 0.01, |e| &mut e.sensor.creep_per_decade),
    field_outside_all("saturation", "N", 1.0, |e| &mut e.sensor.saturation_n),
    field_outside_all("dead", "%", 0.01, |e| &mut e.sensor.dead),
    field_outside_all("wear", "%", 0.01, |e| &mut e.sensor.wear),
    field_outside_all("latency", "ms", 1e-3, |e| &mut e.sensor.latency_s),
    field_outside_all("jitter", "ms", 1e-3, |e| &mut e.sensor.jitter_s),
    field_outside_all("frame-loss", "%", 0.01, |e| &mut e.sensor.frame_loss),
    field_outside_all("servo-lag", "ms", 1e-3, |e| &mut e.servo_lag_s),
];

/// Reason why a text is rejected.
#[derive(Debug, PartialEq, thiserror::Error)]
pub enum ErrorSpecError {
    /// Unknown kind of error.
    #[error("unknown error kind {name:?}; needs all, none, or some of {known}")]
    Unknown {
        /// Requested name.
        name: String,
        /// Known names, with their units.
        known: String,
    },
    /// Invalid amount after the `=`.
    #[error("amount of {name} is {amount:?}, needs a number of {unit} from 0")]
    Amount {
        /// Kind of error.
        name: String,
        /// Given amount.
        amount: String,
        /// Unit of the amount.
        unit: &'static str,
    },
}

impl ErrorKind {
    /// Returns the unit of an amount in the text format.
    #[must_use]
    pub fn unit(&self) -> &'static str {
        let field = FIELDS.iter().find(|field| field.name == self.name);
        field.map_or("", |field| field.unit)
    }
}

impl FromStr for Errors {
    type Err = ErrorSpecError;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let mut errors = Self::NONE;
        for part in text.split(',') {
            let (name, amount) = match part.split_once('=') {
                Some((name, amount)) => (name.trim(), Some(amount.trim())),
                None => (part.trim(), None),
            };
            errors.set(name, amount)?;
        }
        Ok(errors)
    }
}

impl Errors {
    /// Sets one kind of error, or all.
    fn set(&mut self, name: &str, amount: Option<&str>) -> Result<(), ErrorSpecError> {
        let amount = |unit| {
            let number = |text: &str| {
                text.parse()
                    .ok()
                    .filter(|x: &f64| x.is_finite() && *x >= 0.0)
            };
            amount.map(|text| {
                number(text).ok_or_else(|| ErrorSpecError::Amount {
                    name: name.to_owned(),
                    amount: text.to_owned(),
                    unit,
                })
            })
        };
        match name {
            "none" => *self = Self::NONE,
            "all" => {
                let factor = amount("times the stated sizes").transpose()?.unwrap_or(1.0);
                for field in FIELDS.iter().filter(|field| field.in_all) {
                    *(field.field)(self) = factor * field.size();
                }
            }
            _ => {
                let field = FIELDS.iter().find(|field| field.name == name);
                let field = field.ok_or_else(|| unknown(name))?;
                let given = amount(field.unit).transpose()?;
                *(field.field)(self) = given.map_or(field.size(), |amount| amount * field.per_unit);
            }
        }
        Ok(())
    }
}

fn unknown(name: &str) -> ErrorSpecError {
    let known = FIELDS.iter().map(|f| format!("{} ({})", f.name, f.unit));
    ErrorSpecError::Unknown {
        name: name.to_owned(),
        known: known.collect::<Vec<_>>().join(", "),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::SensorErrors;

    #[test]
    fn every_kind_has_a_text_field() {
        let kinds = Errors::KINDS.iter().chain(&Errors::SENSOR_KINDS);
        let kinds = kinds.chain(&Errors::DRIVE_KINDS);
        for (field, kind) in FIELDS.iter().zip(kinds) {
            assert_eq!(field.name, kind.name);
            assert_eq!(kind.name.parse(), Ok(kind.errors), "{}", kind.name);
        }
    }

    #[test]
    fn names_and_amounts_are_parsed() {
        let check = |text: &str, expected: Errors| assert_eq!(text.parse(), Ok(expected), "{text}");
        check("none", Errors::NONE);
        check("all", Errors::ALL);
        check("all,none", Errors::NONE);
        check(
            "position=2, gain",
            Errors {
                position_m: 0.002,
                gain: 0.10,
                ..Errors::NONE
            },
        );
        let text = "all=0.5,crosstalk=5,height=0";
        let errors: Errors = text.parse().expect("valid text");
        assert_eq!((errors.crosstalk, errors.bias_n), (0.05, 0.0025));
        assert_eq!(errors.height_m, 0.0);
        assert_eq!(
            errors.sensor,
            SensorErrors::NONE,
            "all excludes sensor kinds"
        );
        let errors: Errors = "drift=0.1,latency=20".parse().expect("valid text");
        assert_eq!(
            (errors.sensor.drift_n_s, errors.sensor.latency_s),
            (0.1, 0.02)
        );
        let lag: Errors = "all,servo-lag=50".parse().expect("valid text");
        assert_eq!(
            (lag.servo_lag_s, Errors::ALL.servo_lag_s),
            (0.05, 0.0),
            "all excludes the servo lag"
        );
        let degrees: Errors = "yaw=15".parse().expect("valid text");
        assert!((degrees.yaw_rad - Errors::ALL.yaw_rad).abs() < 1e-12);
    }

    #[test]
    fn invalid_texts_are_rejected() {
        let check = |text: &str, part: &str| {
            let refused = text.parse::<Errors>().expect_err(text).to_string();
            assert!(refused.contains(part), "{text}: {refused}");
        };
        check("moon", "crosstalk (%)");
        check("", "unknown error kind \"\"");
        check("gain=-1", "needs a number of % from 0");
        check("gain=NaN", "needs a number");
        check("position=5mm", "\"5mm\"");
        check("all=", "times the stated sizes");
    }
}
