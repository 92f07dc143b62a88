//! What `atas bench` may be told.

use std::path::PathBuf;

use clap::{Args, Subcommand, ValueEnum};
use shm_bus::BusName;

/// `atas bench`.
#[derive(Debug, Subcommand)]
pub enum Bench {
    /// How punctual the daemon is here, beside cyclictest and a bare loop; what a tick costs; how fast transports are
    Latency(BenchLatency),
    /// Whether a stop gets through a flood of goals, long checks and a frozen client
    Stop(BenchStop),
    /// Whether looking on costs the tick anything: unobserved, with eight observers that hang, die and come back, and with the
    /// same eight looking at another daemon
    Observers(BenchObservers),
    /// The other end of a transport that is being measured
    #[command(hide = true)]
    Echo {
        /// By what
        by: EchoBy,
        /// Bus of the echo
        #[arg(long)]
        bus: BusName,
        /// Socket of the echo
        #[arg(long)]
        socket: PathBuf,
    },
}

/// `atas bench latency`.
#[derive(Args, Clone, Debug)]
pub struct BenchLatency {
    /// Two seconds per measurement instead of ten
    #[arg(long, conflicts_with = "seconds")]
    pub short: bool,
    /// Length of each measurement, seconds [default: 10]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..=3600))]
    pub seconds: Option<u64>,
    /// How often each is repeated, in turn with the others; medians are reported
    #[arg(long, value_name = "N", default_value_t = 5, value_parser = clap::value_parser!(u32).range(1..=1000))]
    pub repeats: u32,
}

/// `atas bench stop`.
#[derive(Args, Clone, Debug)]
pub struct BenchStop {
    /// How often the daemon is stopped and recovered
    #[arg(long, value_name = "N", default_value_t = 100, value_parser = clap::value_parser!(u32).range(1..=100_000))]
    pub count: u32,
}

/// `atas bench observers`.
#[derive(Args, Clone, Debug)]
pub struct BenchObservers {
    /// Length of each half of a comparison, seconds
    #[arg(long, value_name = "N", default_value_t = 5, value_parser = clap::value_parser!(u64).range(1..=3600))]
    pub seconds: u64,
    /// How often both halves are measured in turn; medians are reported
    #[arg(long, value_name = "N", default_value_t = 3, value_parser = clap::value_parser!(u32).range(1..=1000))]
    pub repeats: u32,
}

/// Transports that have an echo in this program.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum EchoBy {
    /// Shared memory, one frame there and back
    Iceoryx2,
    /// A Unix stream socket, one frame there and back
    UnixSocket,
    /// Shared memory, both hands' frames and a joint state there, a command back
    Words,
}
