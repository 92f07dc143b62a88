//! Files of sensor models, and the built-in ones.

use std::path::{Path, PathBuf};

use super::{Rejection, SensorModel};
use crate::name::nearest_hint;

/// Reason why a sensor model could not be loaded.
#[derive(Debug, thiserror::Error)]
pub enum SensorModelError {
    /// Unknown built-in name.
    #[error(
        "unknown sensor model: {name:?} is not built in, needs one of {known}{hint}, or the path of \
         a file"
    )]
    Unknown {
        /// Requested name.
        name: String,
        /// Built-in names.
        known: String,
        /// Nearest name as text; empty if none is near.
        hint: String,
    },
    /// Unreadable file.
    #[error(
        "could not read the sensor model {path:?}: {source}; check the path and its permissions"
    )]
    Unreadable {
        /// Path of the file.
        path: PathBuf,
        /// Error of the operating system.
        source: std::io::Error,
    },
    /// Invalid TOML, unknown or missing keys.
    #[error(
        "could not parse the sensor model {origin}: {message}; see the examples in \
         sim-backend/sensors"
    )]
    Malformed {
        /// File, or built-in name.
        origin: String,
        /// Message of the parser, with the position in the text.
        message: String,
    },
    /// Rejected value.
    #[error("sensor model {origin} rejected: {source}; correct the file")]
    Rejected {
        /// File, or built-in name.
        origin: String,
        /// Key, value and limits.
        source: Rejection,
    },
}

macro_rules! built_in {
    ($($name:literal),* $(,)?) => {
        &[$(($name, include_str!(concat!("../../sensors/", $name, ".toml")))),*]
    };
}

/// Built-in sensor models: name and file.
const BUILT_IN: &[(&str, &str)] = built_in!(
    "design",
    "optoforce-omd20",
    "paxini-gen3",
    "uskin",
    "eflesh"
);

impl SensorModel {
    /// Returns the names of the built-in models.
    pub fn names() -> impl Iterator<Item = &'static str> {
        BUILT_IN.iter().map(|(name, _)| *name)
    }

    /// Returns a built-in model.
    ///
    /// # Errors
    /// [`SensorModelError::Unknown`] if the name is not built in.
    pub fn built_in(name: &str) -> Result<Self, SensorModelError> {
        match BUILT_IN.iter().find(|(known, _)| *known == name) {
            Some((_, text)) => Self::parse(text, name),
            None => Err(unknown(name)),
        }
    }

    /// Returns the text of a built-in model's file, with the sources of its values.
    #[must_use]
    pub fn built_in_text(name: &str) -> Option<&'static str> {
        let found = BUILT_IN.iter().find(|(known, _)| *known == name);
        found.map(|(_, text)| *text)
    }

    /// Reads a model from a file.
    ///
    /// # Errors
    /// If the file is unreadable or malformed, or a value is out of range.
    pub fn from_file(path: &Path) -> Result<Self, SensorModelError> {
        let text = atas_text_file::read(path).map_err(|source| SensorModelError::Unreadable {
            path: path.to_owned(),
            source,
        })?;
        Self::parse(&text, &path.display().to_string())
    }

    /// Returns a built-in model, or reads a file if the text looks like a path.
    ///
    /// # Errors
    /// As [`SensorModel::built_in`] and [`SensorModel::from_file`].
    pub fn from_name_or_file(text: &str) -> Result<Self, SensorModelError> {
        let is_path = text.contains(std::path::MAIN_SEPARATOR) || text.ends_with(".toml");
        if is_path {
            Self::from_file(Path::new(text))
        } else {
            Self::built_in(text)
        }
    }

    /// Parses the text of a model file; errors name its `origin`. An omitted key has the value of
    /// [`SensorModel::default`].
    ///
    /// # Errors
    /// [`SensorModelError::Malformed`], [`SensorModelError::Rejected`].
    pub fn parse(text: &str, origin: &str) -> Result<Self, SensorModelError> {
        let model: Self = toml::from_str(text).map_err(|error| SensorModelError::Malformed {
            origin: origin.into(),
            message: error.to_string(),
        })?;
        model.check().map_err(|source| SensorModelError::Rejected {
            origin: origin.into(),
            source,
        })?;
        Ok(model)
    }

    /// Returns the model as the text of a file.
    ///
    /// # Errors
    /// [`Rejection`] if a value is out of range.
    pub fn to_toml(&self) -> Result<String, Rejection> {
        self.check()?;
        // Serialisation cannot fail: only numbers and strings, tables last.
        Ok(toml::to_string(self).unwrap_or_default())
    }
}

fn unknown(name: &str) -> SensorModelError {
    let known: Vec<&str> = SensorModel::names().collect();
    SensorModelError::Unknown {
        name: name.into(),
        hint: nearest_hint(name, &known),
        known: known.join(", "),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn refusal(text: &str) -> String {
        let refused = SensorModel::parse(text, "my.toml").expect_err(text);
        refused.to_string()
    }

    #[test]
    fn built_in_models_survive_a_round_trip() {
        for name in SensorModel::names() {
            let model = SensorModel::built_in(name).expect(name);
            assert!(!model.about.is_empty(), "{name}");
            let text = model.to_toml().expect("valid model");
            assert_eq!(SensorModel::parse(&text, name).expect(&text), model);
            assert!(SensorModel::built_in_text(name).is_some_and(|text| text.contains('#')));
        }
        assert!(SensorModel::built_in_text("moon").is_none());
    }

    #[test]
    fn design_is_the_default_model() {
        let design = SensorModel::built_in("design").expect("built in");
        let same = SensorModel {
            about: design.about.clone(),
            layout: Some("dome-41".to_owned()),
            rate_hz: Some(1000),
            ..SensorModel::default()
        };
        assert_eq!(design, same);
        assert_eq!(
            SensorModel::parse("", "empty.toml").expect("valid"),
            SensorModel::default()
        );
    }

    #[test]
    fn invalid_files_are_rejected_with_key_and_limits() {
        let check = |text: &str, part: &str| {
            let message = refusal(text);
            assert!(
                message.contains(part) && message.contains("my.toml"),
                "{text}: {message}"
            );
        };
        check(
            "noise_n = [-0.1, 0.0]",
            "noise_n is -0.1, needs 0 to 10000; correct the file",
        );
        check("noise_n = [nan, 0.0]", "noise_n is NaN");
        check("noise_n = 0.1", "could not parse");
        check(
            "step_n = [0.0, 0.001]",
            "step_n is 0, needs 0.000001 to 10000",
        );
        check("gain_spread = inf", "gain_spread is inf");
        check("rate_hz = 2000", "rate_hz is 2000, needs 1 to 1000");
        check("layout = \"cube\"", "layout is \"cube\", needs dome-41");
        check(
            "hysteresis = { share = 0.5, full_scale_n = [1, 1] }",
            "hysteresis.share is 0.5",
        );
        check(
            "hysteresis = { share = 0.05 }",
            "missing field `full_scale_n`",
        );
        check("creep = { per_decade = nan }", "creep.per_decade is NaN");
        check(
            "drift = { rate_n_s = [0, 0, 101] }",
            "drift.rate_n_s is 101, needs -100 to 100",
        );
        check(
            "dead = { share = 0.1, reading = \"loud\" }",
            "unknown variant `loud`",
        );
        check(
            "dead = { share = 1.1, reading = \"zero\" }",
            "dead.share is 1.1, needs 0 to 1",
        );
        check("wear = { loss = 2 }", "wear.loss is 2, needs 0 to 1");
        check(
            "frames = { latency_s = 0.6 }",
            "frames.latency_s is 0.6, needs 0 to 0.5",
        );
        check("frames = { stamp = \"never\" }", "unknown variant `never`");
        check("colour = 3", "unknown field `colour`");
    }

    #[test]
    fn unknown_names_and_paths_are_rejected() {
        let refused = |text: &str| {
            let refused = SensorModel::from_name_or_file(text).expect_err(text);
            refused.to_string()
        };
        assert!(refused("desgn").contains("did you mean \"design\"?"));
        assert!(refused("/no/such.toml").contains("check the path"));
    }
}
