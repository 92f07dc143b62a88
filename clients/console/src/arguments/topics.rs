//! What `atas topic` may be told.

use std::time::Duration;

use clap::Subcommand;

use super::BusArgument;
use super::values::duration;

/// `atas topic`.
#[derive(Debug, Subcommand)]
pub enum Topic {
    /// Every service of the bus: what it carries, who writes and reads it
    List(BusArgument),
    /// Print what a service says, until Ctrl-C
    Echo {
        /// Its name, or the end of it: status, tick-report, view
        service: String,
        /// Stop after this many
        #[arg(long, value_name = "N")]
        count: Option<u64>,
        /// Which bus
        #[command(flatten)]
        bus: BusArgument,
    },
    /// Measure how often a service speaks
    Hz {
        /// Its name, or the end of it: status, tick-report, view
        service: String,
        /// For how long
        #[arg(long, value_name = "SECONDS", default_value = "1", value_parser = duration)]
        seconds: Duration,
        /// Which bus
        #[command(flatten)]
        bus: BusArgument,
    },
}
