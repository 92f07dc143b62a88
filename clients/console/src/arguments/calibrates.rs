//! What `atas calibrate` may be told.

use std::path::PathBuf;

use clap::{Args, Subcommand, ValueEnum};

use super::goals::HandName;
use super::values::{csv, finite, picture, toml};

/// The steps of a calibration.
#[derive(Debug, Subcommand)]
pub enum Calibrate {
    /// Tell a person when to load the fingertip with what, and write down when it was loaded
    Guide(Guide),
    /// Fit a calibration to recorded presses, write it, and say how good it is
    Fit(CalibrateFit),
}

/// How a person is guided.
#[derive(Args, Clone, Debug)]
pub struct Guide {
    /// Loads along the normal, N, as weights or a scale give them: 1 kg is 9.81 N
    #[arg(long, value_name = "N", value_delimiter = ',', default_value = "0.5,1,2,3,5", value_parser = finite)]
    pub normal: Vec<f64>,
    /// Loads along each tangential axis, N, under the middle one of the normal loads
    #[arg(long, value_name = "N", value_delimiter = ',', default_value = "0.5,1,-0.5,-1", value_parser = finite, allow_hyphen_values = true)]
    pub tangential: Vec<f64>,
    /// How long each load rests, s
    #[arg(long, value_name = "S", default_value_t = 3.0, value_parser = finite)]
    pub seconds: f64,
    /// The table of steps to write
    #[arg(long, value_name = "STEPS.csv", value_parser = csv)]
    pub out: PathBuf,
}

/// What is fitted to what.
#[derive(Args, Clone, Debug)]
pub struct CalibrateFit {
    /// Presses in the device's own units, as `atas-sensor SENSOR --dry-run` prints them
    #[arg(long, value_name = "FILE")]
    pub presses: PathBuf,
    /// The known forces: steps of `atas calibrate guide`, or another sensor's table with captured_ns and forces [default: columns
    /// normal_n,tangential1_n,tangential2_n of the presses]
    #[arg(long, value_name = "FILE")]
    pub reference: Option<PathBuf>,
    /// The same sensor while nothing touches it: its zero, noise and drift, and with a column temperature_c or temperature_k what a
    /// kelvin does [default: the presses where the known force is 0]
    #[arg(long, value_name = "FILE")]
    pub silence: Option<PathBuf>,
    /// A rigid block pressed between fingertips: closing_m,normal_n
    #[arg(long, value_name = "FILE")]
    pub block: Option<PathBuf>,
    /// Fingertips that pressed the block at once
    #[arg(long, value_name = "N", default_value_t = 2, value_parser = clap::value_parser!(u32).range(1..=4))]
    pub block_tips: u32,
    /// Where the elements sit: dome-41, dome-1, pad-N, flat-RxC-P or cylinder-RxC-P-Q
    #[arg(long, default_value = "dome-1")]
    pub layout: String,
    /// How values become forces [default: resultant-squares for flux, else matrix]
    #[arg(long, value_enum)]
    pub model: Option<CalibrationModel>,
    /// Standard deviations of the sensor's noise at which a touch begins
    #[arg(long, value_name = "N", default_value_t = 8.0, value_parser = finite)]
    pub multiple: f64,
    /// The calibration to write, for `atas-sensor --calibration`
    #[arg(long, value_name = "FILE.toml", value_parser = toml)]
    pub out: PathBuf,
    /// Thresholds and compression to write, for `atasd --config`
    #[arg(long, value_name = "FILE.toml", value_parser = toml)]
    pub daemon: Option<PathBuf>,
    /// The hand that carries the fingertip: its rate stands in the daemon's configuration, too
    #[arg(long, value_enum, requires = "daemon")]
    pub hand: Option<HandName>,
    /// The errors of the presses to draw
    #[arg(long, value_name = "FILE.svg|png|pdf", value_parser = picture)]
    pub figure: Option<PathBuf>,
}

/// How values become forces.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum CalibrationModel {
    /// A 3 × 3 matrix per element: scale, axes, crosstalk
    Matrix,
    /// One force, linear in all values
    Resultant,
    /// One force, with the squares and products of each element's values
    ResultantSquares,
}
