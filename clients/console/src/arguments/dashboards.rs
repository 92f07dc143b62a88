//! Arguments of `atas dashboard` and `atas foxglove`.

use std::path::PathBuf;

use clap::Args;

use super::BusArgument;

/// `atas dashboard`.
#[derive(Args, Clone, Debug)]
pub struct Dashboard {
    /// Show a recording instead of a daemon: files of one run, in order
    #[arg(long, value_name = "FILE", num_args = 1.., conflicts_with = "robot")]
    pub recording: Vec<PathBuf>,
    /// Local TCP port; 0 selects a free port
    #[arg(long, value_name = "PORT", default_value_t = 8470)]
    pub port: u16,
    /// Robot to draw [default: robot of the daemon]; not for recordings, which contain their robot
    #[arg(long, value_name = "NAME|FILE", value_parser = super::values::ROBOTS, hide_possible_values = true)]
    pub robot: Option<String>,
    /// Daemon to show
    #[command(flatten)]
    pub bus: BusArgument,
}

/// `atas foxglove`.
#[derive(Args, Clone, Debug)]
pub struct Foxglove {
    /// Local TCP port; 0 selects a free port
    #[arg(long, value_name = "PORT", default_value_t = 8765)]
    pub port: u16,
    /// Robot to describe [default: robot of the daemon]
    #[arg(long, value_name = "NAME|FILE", value_parser = super::values::ROBOTS, hide_possible_values = true)]
    pub robot: Option<String>,
    /// Print a Foxglove layout for import, then exit
    #[arg(long)]
    pub print_layout: bool,
    /// Daemon to show
    #[command(flatten)]
    pub bus: BusArgument,
}
