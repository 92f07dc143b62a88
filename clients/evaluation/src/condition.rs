//! Conditions of an evaluation: sensor noise, sensor rate, sensor model and errors.

use atas_tasks::Task;
use serde::Serialize;
use sim_backend::{Errors, SensorModel, SensorModelError};

/// Sensor rates, Hz: one frame per tick, and two slower ones (acceptance criterion).
const RATES_HZ: [u32; 3] = [1000, 100, 30];
/// Range of the sensor noise scale in all tasks but the grasp (acceptance criterion: × 1 to 2).
const NOISE: [f64; 2] = [1.0, 2.0];

/// Condition of a trial: sensor quality, and deviations of the world from the nominal model.
#[derive(Clone, Debug, PartialEq)]
pub struct Condition {
    /// Scale of the fingertip sensors' noise.
    pub noise: Noise,
    /// Frames per second of the fingertip sensors.
    pub rate_hz: u32,
    /// Errors of robot, skins, objects, and of the data given to the client.
    pub errors: NamedErrors,
    /// Model of the fingertip sensors; `None` for that of the design.
    pub sensor_model: Option<NamedSensorModel>,
}

/// Sensor model with its name in reports.
#[derive(Clone, Debug, PartialEq)]
pub struct NamedSensorModel {
    /// Built-in name or path, as users type it.
    pub name: String,
    /// The model.
    pub model: SensorModel,
}

impl core::str::FromStr for NamedSensorModel {
    type Err = SensorModelError;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        Ok(Self {
            name: text.to_owned(),
            model: SensorModel::from_name_or_file(text)?,
        })
    }
}

/// Errors with their name in reports.
#[derive(Clone, Debug, PartialEq)]
pub struct NamedErrors {
    /// Specification as users type it: `none`, `crosstalk`, `position=2,yaw=5`.
    pub name: String,
    /// The errors.
    pub errors: Errors,
}

impl NamedErrors {
    /// Returns no errors.
    #[must_use]
    pub fn none() -> Self {
        Self {
            name: "none".to_owned(),
            errors: Errors::NONE,
        }
    }
}

impl core::str::FromStr for NamedErrors {
    type Err = sim_backend::ErrorSpecError;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        Ok(Self {
            name: text.to_owned(),
            errors: text.parse()?,
        })
    }
}

/// Noise scale.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub enum Noise {
    /// Constant.
    Scale(f64),
    /// Drawn for each trial from this range.
    Between([f64; 2]),
}

impl Noise {
    /// Returns the scale of one trial from its random number in 0 to 1.
    pub(super) fn scale(self, share: f64) -> f64 {
        match self {
            Self::Scale(scale) => scale,
            Self::Between([low, high]) => low + (high - low) * share,
        }
    }
}

/// Returns the conditions of the acceptance criteria: usual noise, double noise (grasp only),
/// slower sensors.
#[must_use]
pub fn conditions(task: Task) -> Vec<Condition> {
    let condition = |noise, rate_hz| Condition {
        noise,
        rate_hz,
        errors: NamedErrors::none(),
        sensor_model: None,
    };
    let [full_hz, held_hz, slow_hz] = RATES_HZ;
    let usual = match task {
        Task::Grasp => Noise::Scale(NOISE[0]),
        _ => Noise::Between(NOISE),
    };
    let mut conditions = vec![condition(usual, full_hz)];
    if task == Task::Grasp {
        conditions.push(condition(Noise::Scale(NOISE[1]), full_hz));
    }
    conditions.extend([held_hz, slow_hz].map(|rate_hz| condition(usual, rate_hz)));
    conditions
}

/// Returns the usual condition with no error, with each kind of error alone, and with all at
/// once.
#[must_use]
pub fn error_conditions(task: Task) -> Vec<Condition> {
    let usual = conditions(task).swap_remove(0);
    let kinds = Errors::KINDS.iter().map(|kind| (kind.name, kind.errors));
    let named = [("none", Errors::NONE)].into_iter().chain(kinds);
    named
        .chain([("all", Errors::ALL)])
        .map(|(name, errors)| Condition {
            errors: NamedErrors {
                name: name.to_owned(),
                errors,
            },
            ..usual.clone()
        })
        .collect()
}
