//! What `atas follow` may be told.

use std::path::PathBuf;

use clap::Args;

use super::values::finite;
use super::{BusArgument, HandName};

/// `atas follow`.
#[derive(Args, Clone, Debug)]
pub struct Follow {
    /// Targets: CSV with the header t_s,hand,x_m,y_m,z_m,yaw_rad,opening_m, or JSON lines with the same names; the opening may be
    /// the word hold. Without it, the keys of this terminal lead
    #[arg(value_name = "FILE")]
    pub file: Option<PathBuf>,
    /// Which hand the keys lead; a file names its own
    #[arg(long, value_enum, default_value_t = HandName::Right)]
    pub hand: HandName,
    /// How far a key moves the hand or opens it, millimetres
    #[arg(long, value_name = "MM", default_value_t = 5.0, value_parser = finite)]
    pub step: f64,
    /// How far a key turns it, degrees
    #[arg(long, value_name = "DEG", default_value_t = 5.0, value_parser = finite)]
    pub turn: f64,
    /// Direction of the closing axis at the beginning, degrees from x towards y
    #[arg(long, value_name = "DEG", default_value_t = 90.0, value_parser = finite, allow_hyphen_values = true)]
    pub yaw: f64,
    /// Which daemon
    #[command(flatten)]
    pub bus: BusArgument,
}
