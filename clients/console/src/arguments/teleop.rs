//! Arguments of `atas teleop`.

use std::path::PathBuf;

use clap::Args;

use super::values::finite;
use super::{BusArgument, HandName};

/// `atas teleop`.
#[derive(Args, Clone, Debug)]
pub struct Teleop {
    /// Target file, CSV or JSON lines; without it, the keyboard moves the hand
    ///
    /// Fields: t_s,hand,x_m,y_m,z_m,yaw_rad,opening_m, in CSV as the header. The opening is a
    /// number or the word hold.
    #[arg(value_name = "FILE")]
    pub file: Option<PathBuf>,
    /// Hand that the keyboard moves; a file names its hands
    #[arg(long, value_enum, default_value_t = HandName::Right)]
    pub hand: HandName,
    /// Distance per key press for position and opening, millimetres
    #[arg(long, value_name = "MM", default_value_t = 5.0, value_parser = finite)]
    pub step: f64,
    /// Rotation per key press, degrees
    #[arg(long, value_name = "DEG", default_value_t = 5.0, value_parser = finite)]
    pub turn: f64,
    /// Initial direction of the closing axis, degrees from x towards y
    #[arg(long, value_name = "DEG", default_value_t = 90.0, value_parser = finite, allow_hyphen_values = true)]
    pub yaw: f64,
    /// Daemon of the hand
    #[command(flatten)]
    pub bus: BusArgument,
}
