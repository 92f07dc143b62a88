//! What `atas dashboard` may be told.

use std::path::PathBuf;

use clap::Args;

use super::BusArgument;

/// `atas dashboard`.
#[derive(Args, Clone, Debug)]
pub struct Dashboard {
    /// Show a recording instead of a running daemon: the files of one run, in order
    #[arg(long, value_name = "FILE", num_args = 1.., conflicts_with = "robot")]
    pub recording: Vec<PathBuf>,
    /// Port on this machine; 0 for any that is free
    #[arg(long, value_name = "PORT", default_value_t = 8470)]
    pub port: u16,
    /// URDF of the robot that is drawn [default: the built-in robot; a recording's own]
    #[arg(long, value_name = "FILE.urdf")]
    pub robot: Option<PathBuf>,
    /// Which daemon
    #[command(flatten)]
    pub bus: BusArgument,
}
