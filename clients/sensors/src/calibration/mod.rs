//! Calibration: from what a device says to newtons, fitted to presses whose force is known, and kept in a file.
//!
//! ```text
//!  silence ─▶ zero, noise, drift ─┐
//!  presses with references ───────┼─▶ Calibration ─▶ FILE.toml ─▶ atas-sensor --calibration FILE ─▶ HandFrame
//!  a rigid block, pressed ────────┴─▶ thresholds, compression of the tip ─▶ what the daemon's configuration includes
//! ```
//!
//! Two models. **Matrix**: each element has a 3 × 3 matrix of its own, which holds its scale, its axes and its crosstalk.
//! Only the total force of a press need be known: the elements share one matrix, from which each departs as far as the
//! presses say so. **Resultant**: one force from all values of a fingertip, linear or with squares and products, for skins
//! whose values are no forces, such as magnetic ones.
//!
//! * **In:** numbers in the device's own units, forces in newtons. **Out:** a [`Calibration`], and how good it is on presses
//!   that it was not fitted to.
//! * **Invariants:** what a file says is finite and fits its model, or it is refused; the same presses give the same bits.
//! * **Absent on purpose:** the device and the bus; files with rows (`atas calibrate` reads them); filters.

mod block;
mod drift;
mod fit;
mod least_squares;
mod silence;

pub use block::{Block, press_block};
pub use drift::{Drift, Quiet, WARMING_MIN_K, Warmth};
pub use fit::{FitError, Fitted, Point, Press, fit, total_n};
pub use silence::{Silence, Thresholds, listen};

use std::path::Path;

use serde::{Deserialize, Serialize};

/// What this version writes and reads.
pub const FORMAT: u32 = 1;
/// Values of one element.
pub const AXES: usize = 3;

/// How the values of a fingertip become forces.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Model {
    /// A matrix per element.
    Matrix,
    /// One force, linear in all values.
    Resultant,
    /// One force, with the squares and products of each element's values.
    ResultantSquares,
}

/// One fingertip's calibration.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Calibration {
    /// Version of the file.
    pub format: u32,
    /// Where it comes from, in words.
    pub source: String,
    /// How values become forces.
    pub model: Model,
    /// What every value says of silence, in the device's unit, element by element.
    pub zero: Vec<f64>,
    /// N per unit: of every element (matrix) or of the whole (resultant) the rows of `f_n`, `f_t1` and `f_t2`.
    pub newtons: Vec<[Vec<f64>; AXES]>,
    /// How good it is.
    pub quality: Quality,
    /// How its zero moved when it was calibrated; for people, nothing is corrected by it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub drift: Option<Drift>,
}

/// How good a calibration is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Quality {
    /// Presses that it was fitted to.
    pub presses: u32,
    /// Ridge of a resultant, over what was seen of each term: the one of several that told presses best which were left out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub ridge: Option<f64>,
    /// Root mean square error of the force along `f_n`, `f_t1`, `f_t2` on presses that were left out, N.
    pub error_n: [f64; AXES],
    /// The same over the root mean square of the known force.
    pub error_share: [f64; AXES],
    /// Standard deviation of the total force in silence, N.
    pub noise_n: [f64; AXES],
    /// How far the total force moved in a minute of silence, N.
    pub drift_n_min: f64,
}

/// A calibration that cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum CalibrationError {
    /// The file cannot be read or written.
    #[error("could not {verb} {path}: {error}")]
    File {
        /// What was tried.
        verb: &'static str,
        /// The file.
        path: String,
        /// Why not.
        error: std::io::Error,
    },
    /// It is not what it should be.
    #[error("could not use the calibration {path}: {reason}")]
    Content {
        /// The file.
        path: String,
        /// Why not.
        reason: String,
    },
}

impl Model {
    /// Terms of one element.
    const fn terms(self) -> usize {
        match self {
            Self::Matrix | Self::Resultant => AXES,
            Self::ResultantSquares => 3 * AXES,
        }
    }

    /// The terms of one element's values.
    fn expand(self, [x, y, z]: [f64; AXES]) -> [f64; 3 * AXES] {
        [x, y, z, x * x, y * y, z * z, x * y, y * z, z * x]
    }
}

impl Calibration {
    /// Reads a file.
    ///
    /// # Errors
    /// [`CalibrationError`] with the file and what is wrong with it.
    pub fn open(path: &Path) -> Result<Self, CalibrationError> {
        let name = || path.display().to_string();
        let text = std::fs::read_to_string(path).map_err(|error| CalibrationError::File {
            verb: "read",
            path: name(),
            error,
        })?;
        let refuse = |reason: String| CalibrationError::Content {
            path: name(),
            reason,
        };
        let read: Self = toml::from_str(&text).map_err(|error| refuse(error.to_string()))?;
        read.check().map_err(refuse)?;
        Ok(read)
    }

    /// Writes a new file.
    ///
    /// # Errors
    /// [`CalibrationError`] when it exists or cannot be written.
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

    /// Elements that a device must have.
    #[must_use]
    pub fn elements_in(&self) -> usize {
        self.zero.len() / AXES
    }

    /// Elements of a frame that it gives.
    #[must_use]
    pub fn elements_out(&self) -> usize {
        self.newtons.len()
    }

    /// `[f_n, f_t1, f_t2]`, N, of one element of the frame, from all values of the fingertip. As finite as these are.
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

    /// The same for values whose zero has just been taken: the silence of then is no longer in them.
    #[must_use]
    pub fn of_zeroed(mut self) -> Self {
        self.zero.fill(0.0);
        self
    }

    /// The terms of one element, with the silence taken out.
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
