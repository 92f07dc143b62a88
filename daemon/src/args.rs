//! Command line.

use std::path::PathBuf;

use atas_process::exit::Exit;
use clap::{CommandFactory, Parser, Subcommand, ValueEnum};
use shm_bus::BusName;

use crate::config::Source;

/// The 1 kHz ATAS daemon: reads tactile sensors, commands joints, executes goals.
#[derive(Clone, Debug, Parser)]
#[command(version, long_version = shm_bus::long_version(), after_help = format!("{AFTER_HELP}\n\n{}", Exit::TABLE), args_conflicts_with_subcommands = true)]
pub struct Args {
    /// Command to run instead of the daemon.
    #[command(subcommand)]
    pub command: Option<Command>,
    /// The bus to run on; all processes of one robot use the same.
    #[arg(long, value_name = "NAME", env = BusName::ENV, default_value_t)]
    pub bus: BusName,
    /// Configuration file, may be repeated: later ones win [default: /etc/atas/atas.toml and
    /// /etc/atas/conf.d/*.toml].
    #[arg(long, value_name = "FILE")]
    pub config: Vec<PathBuf>,
    /// The robot: a shipped one (`atas robot list`) or a robot file; same as `--set robot.model=…`.
    #[arg(long, value_name = "NAME|FILE")]
    pub robot: Option<String>,
    /// Overrides one value of the files, may be repeated, for example `--set grasp.dr_n=0.08`.
    #[arg(long, value_name = "KEY=VALUE")]
    pub set: Vec<String>,
    /// Checks the configuration, prints the effective one, and exits.
    #[arg(long)]
    pub check_config: bool,
    /// Prints the built-in tasks as configuration, a starting point for user tasks, and exits.
    #[arg(long)]
    pub print_tasks: bool,
    /// Ticks on each joint state of the simulator instead of the clock. Deterministic; never
    /// real-time.
    #[arg(long)]
    pub lockstep: bool,
    /// Publishes the inputs of every tick, for `atas record`; same as
    /// `--set recording.stream=true`.
    #[arg(long)]
    pub record_stream: bool,
    /// Format of the log on standard error; RUST_LOG sets its level.
    #[arg(long, value_enum, default_value_t = LogFormat::Human)]
    pub log_format: LogFormat,
}

/// Commands other than running the daemon.
#[derive(Clone, Debug, Subcommand)]
pub enum Command {
    /// Print completions for a shell.
    #[command(after_help = "Example:\n  atasd completions bash > /etc/bash_completion.d/atasd")]
    Completions {
        /// Shell.
        shell: clap_complete::Shell,
    },
}

/// Log format.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum LogFormat {
    /// Text for people.
    Human,
    /// One JSON object per line.
    Json,
}

impl From<LogFormat> for atas_process::log::LogFormat {
    fn from(format: LogFormat) -> Self {
        match format {
            LogFormat::Human => Self::Human,
            LogFormat::Json => Self::Json,
        }
    }
}

const AFTER_HELP: &str = "\
Examples:
  atasd
  atasd --bus left-arm --robot my_arm.toml
  atasd --lockstep --config mine.toml --set grasp.dr_n=0.08
  atasd --check-config --set grasp.f2_max_n=6
  atasd --print-tasks

Signals: SIGTERM and SIGINT stop the robot and the daemon, a second one at once; SIGHUP reloads the configuration.
A second one ends the daemon with exit code 130 or 143.";

impl Args {
    /// Source of the configuration.
    #[must_use]
    pub fn source(&self) -> Source {
        Source {
            files: self.config.clone(),
            flags: self.flags(),
        }
    }

    /// Completion script for a shell.
    #[must_use]
    pub fn completions(shell: clap_complete::Shell) -> Vec<u8> {
        // Generated in memory: clap's generator panics on a closed pipe or full disk.
        let mut script = Vec::new();
        clap_complete::generate(shell, &mut Self::command(), "atasd", &mut script);
        script
    }

    fn flags(&self) -> Vec<String> {
        let implied = [
            (self.record_stream, "recording.stream=true"),
            (self.lockstep, "realtime.mode=off"),
        ];
        let implied = implied
            .into_iter()
            .filter(|(is_set, _)| *is_set)
            .map(|(_, flag)| flag.to_owned());
        let robot = self
            .robot
            .iter()
            .map(|robot| format!("robot.model={robot}"));
        self.set
            .iter()
            .cloned()
            .chain(implied)
            .chain(robot)
            .collect()
    }
}
