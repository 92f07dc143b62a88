//! What `atas dashboard` and `atas foxglove` may be told.

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
    /// The robot that is drawn [default: the one that the daemon says it runs]; a recording knows its own
    #[arg(long, value_name = "NAME|FILE")]
    pub robot: Option<String>,
    /// Which daemon
    #[command(flatten)]
    pub bus: BusArgument,
}

/// `atas foxglove`.
#[derive(Args, Clone, Debug)]
pub struct Foxglove {
    /// Port on this machine; 0 for any that is free
    #[arg(long, value_name = "PORT", default_value_t = 8765)]
    pub port: u16,
    /// The robot that is described [default: the one that the daemon says it runs]
    #[arg(long, value_name = "NAME|FILE")]
    pub robot: Option<String>,
    /// Print a layout to import, and end
    #[arg(long)]
    pub print_layout: bool,
    /// Which daemon
    #[command(flatten)]
    pub bus: BusArgument,
}
