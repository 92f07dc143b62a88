//! Commands: what can be asked for, and how answers are printed.

mod agents;
mod evolve;
mod experiment;
mod inspect;
mod options;
mod report;

use std::io::{ErrorKind, Write};
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use clap::{Subcommand, ValueEnum};
use serde::Serialize;

use ebts::error::{Error, Result};

/// How results are printed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Format {
    /// For people.
    Human,
    /// For programs.
    Json,
}

#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Evolve one table (one run of the genetic algorithm).
    Evolve(evolve::EvolveArgs),
    /// Repeat an experiment of the paper: team sizes × seeds, on all cores, resumable.
    Experiment(experiment::ExperimentArgs),
    /// Put the shards of an experiment together.
    Merge(experiment::MergeArgs),
    /// Say with statistics which findings of the paper an experiment shows; compare with baselines and held-out trials.
    Analyse(experiment::AnalyseArgs),
    /// Draw Fig. 14 of an experiment's folder, or trajectories and behaviour of a table file.
    Plot(inspect::PlotArgs),
    /// Show a table in the paper's words, and which of its rows were ever read.
    Show(inspect::ShowArgs),
    /// Drive the robots of a field on the bus by tables, which may be exchanged while they drive.
    Agents(agents::AgentsArgs),
    /// Write an animation of a table at work: one web page that needs nothing else.
    Replay(inspect::ReplayArgs),
}

pub(crate) fn run(command: Command, format: Format) -> Result<()> {
    match command {
        Command::Evolve(args) => evolve::evolve(args, format),
        Command::Experiment(args) => experiment::experiment(args, format),
        Command::Merge(args) => experiment::merge(args, format),
        Command::Analyse(args) => experiment::analyse(args, format),
        Command::Plot(args) => inspect::plot(args, format),
        Command::Show(args) => inspect::show(args, format),
        Command::Agents(args) => agents::agents(args, format),
        Command::Replay(args) => inspect::replay(args, format),
    }
}

/// Prints a result: `human()` or the value as JSON. A reader who has gone away is no error.
fn answer(format: Format, value: &impl Serialize, human: impl FnOnce() -> String) -> Result<()> {
    let mut text = match format {
        Format::Human => human(),
        Format::Json => serde_json::to_string_pretty(value).map_err(Error::from_part)?,
    };
    if !text.ends_with('\n') {
        text.push('\n');
    }
    match std::io::stdout().lock().write_all(text.as_bytes()) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => {
            Err(Error::io("write to", Path::new("standard output"))(error))
        }
        _ => Ok(()),
    }
}

/// Prints an error to standard error.
pub(crate) fn complain(error: &Error) {
    // With standard error gone there is nobody left to tell; the exit code still says it.
    let _ = writeln!(std::io::stderr(), "ebts: {error}");
}

/// A flag that Ctrl-C and SIGTERM set; a second signal ends the process at once.
fn stop_flag() -> Result<Arc<AtomicBool>> {
    let stop = Arc::new(AtomicBool::new(false));
    for signal in [signal_hook::consts::SIGINT, signal_hook::consts::SIGTERM] {
        signal_hook::flag::register_conditional_shutdown(signal, 130, Arc::clone(&stop))
            .and_then(|_| signal_hook::flag::register(signal, Arc::clone(&stop)))
            .map_err(Error::io("watch signals for", Path::new("this process")))?;
    }
    Ok(stop)
}
