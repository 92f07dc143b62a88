//! Arguments of `atas topic`.

use std::time::Duration;

use clap::Subcommand;

use super::BusArgument;
use super::values::duration;

/// `atas topic`.
#[derive(Debug, Subcommand)]
pub enum Topic {
    /// List all services of the bus with payload, writers and readers
    List(BusArgument),
    /// Print the payloads of a service until Ctrl-C
    Echo {
        /// Service name or its end: status, tick-report, view
        service: String,
        /// Stop after this many payloads
        #[arg(long, value_name = "N")]
        count: Option<u64>,
        /// Bus of the service
        #[command(flatten)]
        bus: BusArgument,
    },
    /// Measure the rate of a service
    Hz {
        /// Service name or its end: status, tick-report, view
        service: String,
        /// Measurement time, seconds
        #[arg(long, value_name = "SECONDS", default_value = "1", value_parser = duration)]
        seconds: Duration,
        /// Bus of the service
        #[command(flatten)]
        bus: BusArgument,
    },
}
