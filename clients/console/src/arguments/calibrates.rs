//! Arguments of `atas calibrate`.

use std::path::PathBuf;

use clap::{Args, Subcommand, ValueEnum};

use super::goals::HandName;
use super::values::{csv, finite, picture, toml};

/// Calibration steps.
#[derive(Debug, Subcommand)]
pub enum Calibrate {
    /// Guide a person through the loads of a fingertip and write their times
    Guide(Guide),
    /// Fit a calibration to recorded presses, write it and report its errors
    Fit(CalibrateFit),
    /// Fit a sensor model for the simulator to a recording
    ///
    /// Determines noise, resolution and range; with a true force also latency, hysteresis, creep
    /// and drift. The first half of the recording is fitted, the second half measures the residual.
    Model(CalibrateModel),
}

/// Arguments of `atas calibrate model`.
#[derive(Args, Clone, Debug)]
pub struct CalibrateModel {
    /// Table with one row per frame, in order of time
    ///
    /// Times: column t_s, time_s or captured_ns.
    #[arg(value_name = "FILE.csv")]
    pub recording: PathBuf,
    /// Columns with the readings of one sensor, in any unit
    #[arg(long, value_name = "COLUMN", value_delimiter = ',', required = true)]
    pub reading: Vec<String>,
    /// Column with the true force; empty cells are interpolated [default: force_n, if present]
    #[arg(long, value_name = "COLUMN")]
    pub force: Option<String>,
    /// Newtons per unit of the true force
    #[arg(long, value_name = "N", default_value_t = 1.0, value_parser = finite)]
    pub force_unit: f64,
    /// Newtons per unit of the readings, for a recording without a true force
    #[arg(long, value_name = "N", default_value_t = 1.0, value_parser = finite)]
    pub newtons_per_unit: f64,
    /// Column that numbers separate recordings in the table
    #[arg(long, value_name = "COLUMN")]
    pub group: Option<String>,
    /// Frame rate, if the table has no times
    #[arg(long, value_name = "HZ", default_value_t = 100.0, value_parser = super::values::rate)]
    pub rate_hz: f64,
    /// Stated accuracy of the sensor, N, which the residual is compared with
    #[arg(long, value_name = "N", value_parser = finite)]
    pub accuracy: Option<f64>,
    /// Compare the model with the domain in which the controller was validated; exit with an error
    /// if a value is outside
    #[arg(long)]
    pub check_domain: bool,
    /// Output sensor model, for `atas-sim run --sensor-model`
    #[arg(long, value_name = "FILE.toml", value_parser = toml)]
    pub out: Option<PathBuf>,
}

/// Arguments of `atas calibrate guide`.
#[derive(Args, Clone, Debug)]
pub struct Guide {
    /// Normal loads, N, from weights or a scale (1 kg is 9.81 N)
    #[arg(long, value_name = "N", value_delimiter = ',', default_value = "0.5,1,2,3,5", value_parser = finite)]
    pub normal: Vec<f64>,
    /// Loads along each tangential axis, N, applied under the middle normal load
    #[arg(long, value_name = "N", value_delimiter = ',', default_value = "0.5,1,-0.5,-1", value_parser = finite, allow_hyphen_values = true)]
    pub tangential: Vec<f64>,
    /// Duration of each load, s
    #[arg(long, value_name = "S", default_value_t = 3.0, value_parser = finite)]
    pub seconds: f64,
    /// Output table of the steps
    #[arg(long, value_name = "STEPS.csv", value_parser = csv)]
    pub out: PathBuf,
}

/// Arguments of `atas calibrate fit`.
#[derive(Args, Clone, Debug)]
pub struct CalibrateFit {
    /// Presses in raw device units, as printed by `atas-sensor SENSOR --dry-run`
    #[arg(long, value_name = "FILE")]
    pub presses: PathBuf,
    /// Reference forces: steps of `atas calibrate guide`, or a table with captured_ns and forces
    ///
    /// [default: columns normal_n,tangential1_n,tangential2_n of the presses]
    #[arg(long, value_name = "FILE")]
    pub reference: Option<PathBuf>,
    /// Recording of the same sensor without contact, for zero, noise and drift
    ///
    /// A column temperature_c or temperature_k adds the temperature dependence. [default: presses
    /// with reference force 0]
    #[arg(long, value_name = "FILE")]
    pub silence: Option<PathBuf>,
    /// Presses of a rigid block between fingertips: closing_m,normal_n
    #[arg(long, value_name = "FILE")]
    pub block: Option<PathBuf>,
    /// Number of fingertips that press the block together
    #[arg(long, value_name = "N", default_value_t = 2, value_parser = clap::value_parser!(u32).range(1..=4))]
    pub block_tips: u32,
    /// Layout of the elements: dome-41, dome-1, pad-N, flat-RxC-P or cylinder-RxC-P-Q
    #[arg(long, default_value = "dome-1")]
    pub layout: String,
    /// Model from raw values to forces [default: resultant-squares for flux, else matrix]
    #[arg(long, value_enum)]
    pub model: Option<CalibrationModel>,
    /// Contact threshold, standard deviations of the sensor noise
    #[arg(long, value_name = "N", default_value_t = 8.0, value_parser = finite)]
    pub multiple: f64,
    /// Output calibration, for `atas-sensor --calibration`
    #[arg(long, value_name = "FILE.toml", value_parser = toml)]
    pub out: PathBuf,
    /// Output thresholds and compression, for `atasd --config`
    #[arg(long, value_name = "FILE.toml", value_parser = toml)]
    pub daemon: Option<PathBuf>,
    /// Hand of the fingertip; also writes its frame rate to the daemon configuration
    #[arg(long, value_enum, requires = "daemon")]
    pub hand: Option<HandName>,
    /// Plot of the errors of the presses
    #[arg(long, value_name = "FILE.svg|png|pdf", value_parser = picture)]
    pub figure: Option<PathBuf>,
}

/// Model from raw values to forces.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum CalibrationModel {
    /// 3 × 3 matrix per element: scale, axes, crosstalk
    Matrix,
    /// One force, linear in all values
    Resultant,
    /// One force, including squares and products of the values of each element
    ResultantSquares,
}
