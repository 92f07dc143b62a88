//! Sensor model: how a real tactile sensor differs from the true forces, as pure data.
//!
//! Values are per element, unless stated otherwise. A pair `[normal, shear]` holds the value of the
//! normal axis and that of both tangential axes. The default model has the constants of the tactile
//! design; its optional effects are off.
//!
//! ```
//! use sim_backend::{CreepModel, SensorModel};
//!
//! let model = SensorModel {
//!     creep: Some(CreepModel { per_decade: 0.05 }),
//!     ..SensorModel::default()
//! };
//! assert!(model.check().is_ok());
//! // A model file contains the same keys.
//! let parsed = SensorModel::parse("creep = { per_decade = 0.05 }", "my-sensor.toml");
//! assert_eq!(parsed.expect("valid model"), model);
//! ```

use serde::{Deserialize, Serialize};
use shm_schemas::Layout;
use shm_schemas::layout::NamedLayout;

pub use file::SensorModelError;

mod file;

/// Additive noise per element and axis, N, standard deviation (tactile design).
const NOISE_N: f64 = 0.003;
/// Proportional noise, standard deviation over the reading (tactile design).
const NOISE_RATIO: f64 = 0.01;
/// Standard deviation of the element gains (tactile design).
const GAIN_SPREAD: f64 = 0.03;
/// Resolution of a reading, N (tactile design).
const STEP_N: f64 = 0.001;

/// Reason why the values of a model are rejected.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Rejection {
    /// Value out of range.
    #[error("{key} is {value}, needs {lower} to {upper}")]
    OutOfRange {
        /// Key of the value.
        key: &'static str,
        /// Rejected value.
        value: f64,
        /// Lowest allowed value.
        lower: f64,
        /// Highest allowed value.
        upper: f64,
    },
    /// Unknown layout.
    #[error("layout is {0:?}, needs {forms}", forms = NamedLayout::FORMS)]
    Layout(String),
}

/// Model of a tactile sensor.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct SensorModel {
    /// Sensor family and origin of the values, one line.
    pub about: String,
    /// Layout whose elements the values describe, such as `dome-1`; `None` if they suit any layout.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub layout: Option<String>,
    /// Usual frame rate, Hz; `None` leaves the rate of the scene.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rate_hz: Option<u32>,
    /// Standard deviation of the element gains around 1; each element draws its own.
    pub gain_spread: f64,
    /// Largest share of another axis' force in a reading; each element draws its own matrix.
    pub crosstalk: f64,
    /// Largest constant offset per axis, N; each element draws its own.
    pub bias_n: f64,
    /// Standard deviation of the additive noise, N: normal, shear.
    pub noise_n: [f64; 2],
    /// Standard deviation of the proportional noise, relative to the force.
    pub noise_ratio: f64,
    /// Step of a reading, N: normal, shear.
    pub step_n: [f64; 2],
    /// Largest magnitude of a reading, N: normal, shear. `None` for an unlimited range.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub saturation_n: Option<[f64; 2]>,
    /// Hysteresis.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub hysteresis: Option<HysteresisModel>,
    /// Viscoelastic creep.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub creep: Option<CreepModel>,
    /// Thermal drift of the zero.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub drift: Option<DriftModel>,
    /// Dead elements.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub dead: Option<DeadModel>,
    /// Wear: loss of gain.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub wear: Option<WearModel>,
    /// Transport of the frames.
    pub frames: FrameModel,
}

/// Rate-independent hysteresis of each axis.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct HysteresisModel {
    /// Difference between unloading and loading at half of the peak, relative to the peak, in a
    /// cycle between zero and full scale.
    pub share: f64,
    /// Full scale, N: normal, shear. Cycles below 1/16 of it have less hysteresis.
    pub full_scale_n: [f64; 2],
}

/// Viscoelastic creep of each axis under constant force.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CreepModel {
    /// Rise of the reading per decade of time, relative to the reading 1 s after the load. Valid
    /// from 0.1 s to 100 s; negative for a reading that decreases.
    pub per_decade: f64,
}

/// Ramp of the zero, as during warm-up; the same for all elements of a fingertip.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DriftModel {
    /// Rate of the fingertip's total force along its axes `[f_n, f_t1, f_t2]`, N/s. Every element
    /// drifts by the same part of it.
    pub rate_n_s: [f64; 3],
    /// Largest drift of the total force per axis, N.
    #[serde(default = "unlimited_n")]
    pub limit_n: f64,
    /// Time at which the drift begins, s from the start of the simulation.
    #[serde(default)]
    pub from_s: f64,
}

/// Elements that do not respond to force.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DeadModel {
    /// Probability that an element is dead.
    pub share: f64,
    /// Reading of a dead element.
    pub reading: DeadReading,
    /// Time at which the elements fail, s from the start of the simulation.
    #[serde(default)]
    pub from_s: f64,
}

/// Reading of a dead element.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum DeadReading {
    /// Zero on all axes.
    Zero,
    /// The last reading before the failure.
    Last,
}

/// Loss of gain.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct WearModel {
    /// Loss at the start, relative to the gain of a new sensor.
    pub loss: f64,
    /// Loss per impulse of the normal force on the element, 1/(N·s).
    pub loss_per_n_s: f64,
    /// Largest loss.
    pub loss_max: f64,
}

/// Transport of the frames from the sensor to its reader.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct FrameModel {
    /// Shortest time from the sample to the arrival of its frame, s. Arrivals are in whole ticks.
    pub latency_s: f64,
    /// Longest additional time, s; each frame draws its own from 0. Frames keep their order.
    pub jitter_s: f64,
    /// Probability that a frame is lost; the sequence number shows the gap.
    pub loss: f64,
    /// Time stamp of a frame.
    pub stamp: FrameStamp,
}

/// Time stamp of a frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum FrameStamp {
    /// Time of arrival: for devices without a clock, whose driver stamps the frame. The reader
    /// cannot measure the latency.
    #[default]
    Arrival,
    /// Time of the sample: for devices that send their own time.
    Sample,
}

impl Default for WearModel {
    /// Returns no wear; without a given limit, the loss may be complete.
    fn default() -> Self {
        Self {
            loss: 0.0,
            loss_per_n_s: 0.0,
            loss_max: 1.0,
        }
    }
}

impl Default for SensorModel {
    /// Returns the model of the tactile design: noise, gain spread and resolution only.
    fn default() -> Self {
        Self {
            about: String::new(),
            layout: None,
            rate_hz: None,
            gain_spread: GAIN_SPREAD,
            crosstalk: 0.0,
            bias_n: 0.0,
            noise_n: [NOISE_N; 2],
            noise_ratio: NOISE_RATIO,
            step_n: [STEP_N; 2],
            saturation_n: None,
            hysteresis: None,
            creep: None,
            drift: None,
            dead: None,
            wear: None,
            frames: FrameModel::default(),
        }
    }
}

/// Default limit of a drift, N: the upper end of its range.
fn unlimited_n() -> f64 {
    range::FORCE_N[1]
}

/// Allowed ranges. Design choice: wide enough for any sensor that a hand can use, and within the
/// range in which the effects are defined.
mod range {
    /// Below this share every play operator has a positive weight (see `hysteresis.rs`).
    pub(super) const HYSTERESIS: [f64; 2] = [0.0, 0.2];
    pub(super) const CREEP: [f64; 2] = [-0.2, 0.5];
    pub(super) const SHARE: [f64; 2] = [0.0, 1.0];
    pub(super) const GAIN_SPREAD: [f64; 2] = [0.0, 0.5];
    /// Forces and offsets.
    pub(super) const FORCE_N: [f64; 2] = [0.0, 1e4];
    /// Scales, which must not be zero.
    pub(super) const SCALE_N: [f64; 2] = [1e-6, 1e4];
    pub(super) const RATE_N_S: [f64; 2] = [-100.0, 100.0];
    pub(super) const RATE_HZ: [f64; 2] = [1.0, 1000.0];
    pub(super) const TIME_S: [f64; 2] = [0.0, 1e6];
    /// Longest delay of a frame: its queue has one place per millisecond.
    pub(super) const DELAY_S: [f64; 2] = [0.0, 0.5];
}

impl SensorModel {
    /// Rejects a model that cannot be simulated.
    ///
    /// # Errors
    /// [`Rejection`] with the key, the value and its limits.
    pub fn check(&self) -> Result<(), Rejection> {
        if let Some(name) = &self.layout
            && Layout::from_name(name).is_none()
        {
            return Err(Rejection::Layout(name.clone()));
        }
        if let Some(rate_hz) = self.rate_hz {
            check("rate_hz", f64::from(rate_hz), range::RATE_HZ)?;
        }
        check("gain_spread", self.gain_spread, range::GAIN_SPREAD)?;
        check("crosstalk", self.crosstalk, range::SHARE)?;
        check("bias_n", self.bias_n, range::FORCE_N)?;
        check_pair("noise_n", self.noise_n, range::FORCE_N)?;
        check("noise_ratio", self.noise_ratio, range::SHARE)?;
        check_pair("step_n", self.step_n, range::SCALE_N)?;
        if let Some(saturation_n) = self.saturation_n {
            check_pair("saturation_n", saturation_n, range::SCALE_N)?;
        }
        self.check_skin()?;
        self.frames.check()
    }

    fn check_skin(&self) -> Result<(), Rejection> {
        if let Some(of) = &self.hysteresis {
            check("hysteresis.share", of.share, range::HYSTERESIS)?;
            check_pair("hysteresis.full_scale_n", of.full_scale_n, range::SCALE_N)?;
        }
        if let Some(of) = &self.creep {
            check("creep.per_decade", of.per_decade, range::CREEP)?;
        }
        if let Some(of) = &self.drift {
            for rate_n_s in of.rate_n_s {
                check("drift.rate_n_s", rate_n_s, range::RATE_N_S)?;
            }
            check("drift.limit_n", of.limit_n, range::FORCE_N)?;
            check("drift.from_s", of.from_s, range::TIME_S)?;
        }
        if let Some(of) = &self.dead {
            check("dead.share", of.share, range::SHARE)?;
            check("dead.from_s", of.from_s, range::TIME_S)?;
        }
        if let Some(of) = &self.wear {
            check("wear.loss", of.loss, range::SHARE)?;
            check("wear.loss_per_n_s", of.loss_per_n_s, range::SHARE)?;
            check("wear.loss_max", of.loss_max, range::SHARE)?;
        }
        Ok(())
    }
}

impl FrameModel {
    fn check(&self) -> Result<(), Rejection> {
        check("frames.latency_s", self.latency_s, range::DELAY_S)?;
        check("frames.jitter_s", self.jitter_s, range::DELAY_S)?;
        check("frames.loss", self.loss, range::SHARE)
    }

    /// Returns true if frames arrive at once and without loss.
    #[must_use]
    pub fn is_immediate(&self) -> bool {
        self.latency_s == 0.0 && self.jitter_s == 0.0 && self.loss == 0.0
    }
}

fn check_pair(key: &'static str, values: [f64; 2], range: [f64; 2]) -> Result<(), Rejection> {
    values
        .into_iter()
        .try_for_each(|value| check(key, value, range))
}

/// Rejects a value outside its range, and NaN.
fn check(key: &'static str, value: f64, [lower, upper]: [f64; 2]) -> Result<(), Rejection> {
    if value >= lower && value <= upper {
        return Ok(());
    }
    Err(Rejection::OutOfRange {
        key,
        value,
        lower,
        upper,
    })
}
