//! Calibration: converts device values to newtons; fitted to presses of known force, stored in a
//! file.
//!
//! ```text
//! unloaded recording ─▶ zero, noise, drift ─┐
//! presses with references ──────────────────┼─▶ Calibration ─▶ FILE.toml ─▶ atas-sensor
//! presses on a rigid block ─────────────────┴─▶ thresholds, compression ─▶ daemon configuration
//! ```
//!
//! * **Matrix** model: each element has a 3 × 3 matrix with scale, axes and crosstalk. The fit
//!   needs only the total force of a press: elements share one matrix and deviate as far as the
//!   presses require.
//! * **Resultant** model: one force from all values of a fingertip, linear or with squares and
//!   products; for skins that do not measure forces, such as magnetic ones.
//! * **Inputs:** device values, forces in newtons. **Outputs:** a [`Calibration`] and its error on
//!   left-out presses.
//! * **Invariants:** non-finite or mismatched files are rejected; equal presses give bit-identical
//!   results.
//! * **Out of scope:** devices, the bus, filters, and recorded tables (`atas calibrate` reads
//!   them).

mod block;
mod drift;
mod fit;
mod least_squares;
mod silence;

pub use block::{Block, fit_block};
pub use drift::{Drift, TemperatureEffect, UnloadedRecording, WARMING_MIN_K};
pub use fit::{FitError, FitResult, Point, Press, fit, total_n};
pub use least_squares::NormalEquations;
pub use silence::{Silence, Thresholds, measure_silence};

use std::path::Path;

use serde::{Deserialize, Serialize};

/// Version of the file format.
pub const FORMAT: u32 = 1;
/// Values per element.
pub const AXES: usize = 3;

/// Conversion from a fingertip's values to forces.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Model {
    /// One matrix per element.
    Matrix,
    /// One force, linear in all values.
    Resultant,
    /// One force, with squares and products.
    ResultantSquares,
}

/// Calibration of one fingertip.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Calibration {
    /// Version of the file format.
    pub format: u32,
    /// Origin, free text.
    pub source: String,
    /// Model of the conversion.
    pub model: Model,
    /// Unloaded values in device units, element by element.
    pub zero: Vec<f64>,
    /// Rows of `f_n`, `f_t1` and `f_t2`, N per unit, per element (matrix) or for the fingertip
    /// (resultant).
    pub newtons: Vec<[Vec<f64>; AXES]>,
    /// Accuracy.
    pub quality: Quality,
    /// Drift of the zero during calibration; informative only.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub drift: Option<Drift>,
}

/// Accuracy of a calibration.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Quality {
    /// Number of fitted presses.
    pub presses: u32,
    /// Ridge of a resultant model, relative to each term's sum of squares.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub ridge: Option<f64>,
    /// Root mean square error along `f_n`, `f_t1`, `f_t2` on left-out presses, N.
    pub error_n: [f64; AXES],
    /// `error_n` divided by the root mean square of the known force.
    pub error_share: [f64; AXES],
    /// Standard deviation of the unloaded total force, N.
    pub noise_n: [f64; AXES],
    /// Drift of the unloaded total force, N per minute.
    pub drift_n_min: f64,
}

/// Error of a calibration file.
#[derive(Debug, thiserror::Error)]
pub enum CalibrationError {
    /// The file cannot be read or written.
    #[error("could not {verb} {path}: {error}")]
    File {
        /// Failed operation.
        verb: &'static str,
        /// Path.
        path: String,
        /// Cause.
        error: std::io::Error,
    },
    /// The content is invalid.
    #[error("could not use the calibration {path}: {reason}")]
    Content {
        /// Path.
        path: String,
        /// Cause.
        reason: String,
    },
}

impl Model {
    const fn terms(self) -> usize {
        match self {
            Self::Matrix | Self::Resultant => AXES,
            Self::ResultantSquares => 3 * AXES,
        }
    }

    fn expand(self, [x, y, z]: [f64; AXES]) -> [f64; 3 * AXES] {
        [x, y, z, x * x, y * y, z * z, x * y, y * z, z * x]
    }
}

impl Calibration {
    /// Reads a calibration file.
    ///
    /// # Errors
    /// [`CalibrationError`] with the file and the cause.
    pub fn open(path: &Path) -> Result<Self, CalibrationError> {
        let name = || path.display().to_string();
        let text = atas_text_file::read(path).map_err(|error| CalibrationError::File {
            verb: "read",
            path: name(),
            error,
        })?;
        Self::parse(&text).map_err(|reason| CalibrationError::Content {
            path: name(),
            reason,
        })
    }

    /// Parses the text of a calibration file.
    ///
    /// # Errors
    /// The cause as text.
    pub fn parse(text: &str) -> Result<Self, String> {
        let read: Self = toml::from_str(text).map_err(|error| error.to_string())?;
        read.check()?;
        Ok(read)
    }

    /// Writes a new file.
    ///
    /// # Errors
    /// [`CalibrationError`] if it exists or cannot be written.
    pub fn save(&self, path: &Path) -> Result<(), CalibrationError> {
        let failed = |error| CalibrationError::File {
            verb: "write",
            path: path.display().to_string(),
            error,
        };
        let text = toml::to_string(self).map_err(|error| failed(std::io::Error::other(error)))?;
        let mut file = std::fs::File::create_new(path).map_err(failed)?;
        std::io::Write::write_all(&mut file, text.as_bytes()).map_err(failed)
    }

    /// Returns the device's element count.
    #[must_use]
    pub fn elements_in(&self) -> usize {
        self.zero.len() / AXES
    }

    /// Returns the element count of its output.
    #[must_use]
    pub fn elements_out(&self) -> usize {
        self.newtons.len()
    }

    /// Returns `[f_n, f_t1, f_t2]`, N, of one frame element; finite if the values are.
    #[must_use]
    pub fn force_n(&self, element: usize, values: &[f64]) -> [f64; AXES] {
        let Some(rows) = self.newtons.get(element) else {
            return [f64::NAN; AXES];
        };
        let first = match self.model {
            Model::Matrix => element,
            Model::Resultant | Model::ResultantSquares => 0,
        };
        let of = match self.model {
            Model::Matrix => 1,
            Model::Resultant | Model::ResultantSquares => self.elements_in(),
        };
        let mut force_n = [0.0; AXES];
        for element in first..first + of {
            let terms = self.terms(element, values);
            let begin = (element - first) * self.model.terms();
            for (force_n, row) in force_n.iter_mut().zip(rows) {
                let row = &row[begin..begin + self.model.terms()];
                *force_n += row
                    .iter()
                    .zip(&terms)
                    .map(|(n, term)| n * term)
                    .sum::<f64>();
            }
        }
        force_n
    }

    /// Clears the stored zero, for a device that has just been zeroed.
    #[must_use]
    pub fn without_zero(mut self) -> Self {
        self.zero.fill(0.0);
        self
    }

    fn terms(&self, element: usize, values: &[f64]) -> [f64; 3 * AXES] {
        let value = |axis: usize| {
            let index = AXES * element + axis;
            values.get(index).copied().unwrap_or(f64::NAN) - self.zero[index]
        };
        self.model.expand([value(0), value(1), value(2)])
    }

    fn check(&self) -> Result<(), String> {
        if self.format != FORMAT {
            return Err(format!(
                "its format is {}, needs {FORMAT}; calibrate again",
                self.format
            ));
        }
        let elements = self.elements_in();
        if elements == 0 || self.zero.len() != AXES * elements {
            return Err(format!(
                "zero has {} values, needs {AXES} per element",
                self.zero.len()
            ));
        }
        let (outputs, row) = match self.model {
            Model::Matrix => (elements, AXES),
            Model::Resultant | Model::ResultantSquares => (1, elements * self.model.terms()),
        };
        let fits = self.newtons.len() == outputs
            && self.newtons.iter().flatten().all(|of| of.len() == row);
        if !fits {
            return Err(format!(
                "newtons needs {outputs} times {AXES} rows of {row} numbers for {elements} elements"
            ));
        }
        let mut numbers = self
            .zero
            .iter()
            .chain(self.newtons.iter().flatten().flatten());
        let drift_is_finite = self.drift.as_ref().is_none_or(Drift::is_finite);
        if numbers.any(|number| !number.is_finite()) || !drift_is_finite {
            return Err("it holds a number that is not finite".to_owned());
        }
        Ok(())
    }
}
