//! Arguments of `atas bench`.

use std::path::PathBuf;

use clap::{Args, Subcommand, ValueEnum};
use shm_bus::BusName;

/// `atas bench`.
#[derive(Debug, Subcommand)]
pub enum Bench {
    /// Measure daemon timing next to cyclictest and an empty loop, tick cost and transport speed
    Latency(BenchLatency),
    /// Test stops during a flood of goals, long checks and a frozen client
    Stop(BenchStop),
    /// Kill the daemon at random moments of its start, of a goal and of a grip; measure the restart
    ///
    /// Each kill is a SIGKILL. The daemon records, and a quarter of the kills follow a reload of the
    /// configuration. An independent judge checks every command, and that a lifted object stays in
    /// the hand.
    Restart(BenchRestart),
    /// Measure the effect of observers on the tick
    ///
    /// Compares three cases: no observers, eight observers that hang, die and restart, and the same
    /// eight observers on another daemon.
    Observers(BenchObservers),
    /// Echo process of a transport measurement
    #[command(hide = true)]
    Echo {
        /// Transport
        by: EchoTransport,
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
    /// Duration of each measurement, seconds [default: 10]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..=3600))]
    pub seconds: Option<u64>,
    /// Interleaved repetitions of each measurement; medians are reported
    #[arg(long, value_name = "N", default_value_t = 5, value_parser = clap::value_parser!(u32).range(1..=1000))]
    pub repeats: u32,
}

/// `atas bench stop`.
#[derive(Args, Clone, Debug)]
pub struct BenchStop {
    /// Number of stop and recover cycles
    #[arg(long, value_name = "N", default_value_t = 100, value_parser = clap::value_parser!(u32).range(1..=100_000))]
    pub count: u32,
}

/// `atas bench restart`.
#[derive(Args, Clone, Debug)]
pub struct BenchRestart {
    /// Number of kills
    #[arg(long, value_name = "N", default_value_t = 100, value_parser = clap::value_parser!(u64).range(1..=1_000_000))]
    pub count: u64,
    /// Seed of the worlds and of the moments; 1 to 20000 are reserved for tuning
    #[arg(long, value_name = "N", default_value_t = 20_001)]
    pub seed: u64,
    /// Robot: a built-in one (`atas robot list`) or a robot file [default: that of --config, else
    /// two-hand-arm]
    #[arg(long, value_name = "NAME|FILE")]
    pub robot: Option<String>,
    /// Configuration of the daemon [default: built-in values]
    #[arg(long, value_name = "FILE")]
    pub config: Option<PathBuf>,
}

/// `atas bench observers`.
#[derive(Args, Clone, Debug)]
pub struct BenchObservers {
    /// Duration of each half of a comparison, seconds
    #[arg(long, value_name = "N", default_value_t = 5, value_parser = clap::value_parser!(u64).range(1..=3600))]
    pub seconds: u64,
    /// Alternating repetitions of both halves; medians are reported
    #[arg(long, value_name = "N", default_value_t = 3, value_parser = clap::value_parser!(u32).range(1..=1000))]
    pub repeats: u32,
}

/// Transports with an echo process.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum EchoTransport {
    /// Shared memory: one frame in each direction
    Iceoryx2,
    /// Unix stream socket: one frame in each direction
    UnixSocket,
    /// Shared memory: frames of both hands and a joint state to the echo, a command back
    Words,
}
