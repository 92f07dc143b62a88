//! Command line: commands and output of results.

mod agents;
mod analyse;
mod course;
mod evolve;
mod experiment;
mod fields;
mod grasp;
mod inspect;
mod manual;
mod options;
mod preset;
mod progress;
mod report;
mod search;
mod slurm;
mod sweep;
mod transfer;

use std::fmt::Display;
use std::io::{ErrorKind, Write};
use std::ops::ControlFlow;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use atas_process::exit::Exit;
use atas_process::shutdown;
use clap::{Parser, Subcommand, ValueEnum};
use serde::Serialize;

use ebts::error::{Error, Result};

pub(crate) use fields::command;

/// Output format of results.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Format {
    /// Text and tables.
    Human,
    /// JSON.
    Json,
}

/// Evolutionary behaviour tables for teams of mobile robots.
#[derive(Debug, Parser)]
#[command(name = "ebts", version, long_version = shm_bus::long_version(), max_term_width = 100, after_help = format!("{AFTER_HELP}\n\n{}", Exit::TABLE))]
pub(crate) struct Arguments {
    /// Output format of results.
    ///
    /// Results go to standard output as text and tables or as one JSON value (`agents`: one object
    /// per line). Progress and errors go to standard error.
    #[arg(long, global = true, value_enum, default_value_t = Format::Human)]
    format: Format,
    #[command(subcommand)]
    command: Command,
}

const AFTER_HELP: &str = "Examples:
  ebts evolve --agents 2 --seed 71 --out mine.toml
  ebts show mine.toml
  ebts experiment fig14 --seeds 80 --out fig14 --format json

After an interruption every finished run is saved.";

#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Evolve one table (one run of the genetic algorithm).
    Evolve(evolve::EvolveArgs),
    /// Repeat an experiment of the paper: team sizes × seeds, on all cores, resumable.
    Experiment(experiment::ExperimentArgs),
    /// Repeat an experiment for every combination of some values of a preset.
    Sweep(sweep::SweepArgs),
    /// Search for a preset on which chosen findings of the paper hold.
    ///
    /// Presets are chosen with some seeds and evaluated with others.
    Search(search::SearchArgs),
    /// Write scripts for shards of an experiment on a cluster: Slurm, Kubernetes, GNU parallel.
    Slurm(slurm::SlurmArgs),
    /// Measure the agreement of reduced and full grasp simulation.
    Agreement(grasp::AgreementArgs),
    /// Merge the shards of an experiment.
    Merge(experiment::MergeArgs),
    /// Analyse the findings of an experiment, with baselines and held-out trials.
    Analyse(analyse::AnalyseArgs),
    /// Measure the fitness of tables on unseen starts and goals.
    Transfer(transfer::TransferArgs),
    /// Compare the findings of several experiments side by side.
    Compare(analyse::CompareArgs),
    /// Export the trials of an experiment as CSV, one row per trial.
    Export(analyse::ExportArgs),
    /// Find and draw the two cases of Fig. 17 among the trials of an experiment.
    Find(analyse::FindArgs),
    /// List the built-in fields, or print one as a file to edit.
    Preset(preset::PresetArgs),
    /// Draw Fig. 14 of an experiment's folder, or trajectories and behaviour of a table file.
    Plot(inspect::PlotArgs),
    /// Show a table in the paper's words, and the rows that were read.
    Show(inspect::ShowArgs),
    /// Control the robots of a field on the bus by tables.
    ///
    /// SIGHUP exchanges the tables while the robots move.
    Agents(agents::AgentsArgs),
    /// Write an animation of a table as a self-contained web page.
    Replay(inspect::ReplayArgs),
    /// Print shell completions.
    Completions(manual::CompletionsArgs),
    /// Write manual pages to a folder.
    Man(manual::ManArgs),
}

impl Arguments {
    /// Returns whether results and errors are printed as JSON.
    pub(crate) fn is_json(&self) -> bool {
        self.format == Format::Json
    }
}

pub(crate) fn run(arguments: Arguments) -> Result<()> {
    let format = arguments.format;
    match arguments.command {
        Command::Evolve(args) => evolve::evolve(args, format),
        Command::Experiment(args) => experiment::experiment(args, format),
        Command::Sweep(args) => sweep::sweep(args, format),
        Command::Search(args) => search::search(args, format),
        Command::Slurm(args) => slurm::slurm(args, format),
        Command::Agreement(args) => grasp::agreement(args, format),
        Command::Merge(args) => experiment::merge(args, format),
        Command::Analyse(args) => analyse::analyse(args, format),
        Command::Transfer(args) => transfer::run(args, format),
        Command::Compare(args) => analyse::compare(args, format),
        Command::Export(args) => analyse::export(args, format),
        Command::Find(args) => analyse::find(args, format),
        Command::Preset(args) => preset::print(args, format),
        Command::Plot(args) => inspect::plot(args, format),
        Command::Show(args) => inspect::show(args, format),
        Command::Agents(args) => agents::agents(args, format),
        Command::Replay(args) => inspect::replay(args, format),
        Command::Completions(args) => manual::completions(args, &mut command()),
        Command::Man(args) => manual::pages(args, command(), format),
    }
}

/// Prints a result: `human()` or the value as JSON. A closed reader is not an error.
fn answer(format: Format, value: &impl Serialize, human: impl FnOnce() -> String) -> Result<()> {
    let mut text = match format {
        Format::Human => human(),
        Format::Json => serde_json::to_string_pretty(value).map_err(Error::from_part)?,
    };
    if !text.ends_with('\n') {
        text.push('\n');
    }
    print(text.as_bytes())
}

fn print(text: &[u8]) -> Result<()> {
    let mut out = std::io::stdout().lock();
    match out.write_all(text).and_then(|()| out.flush()) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => {
            Err(Error::io("write to", Path::new("standard output"))(error))
        }
        _ => Ok(()),
    }
}

fn warn(what: impl Display) {
    // A closed standard error is ignored.
    let _written = writeln!(std::io::stderr(), "ebts: {what}");
}

/// Rejects an existing output file without --overwrite.
fn check_overwrite(out: &Path, overwrite: bool) -> Result<()> {
    if out.exists() && !overwrite {
        return Err(Error::refused(
            format_args!("write {}", out.display()),
            "the file exists already",
            "a new name",
            "choose another --out, or add --overwrite",
        ));
    }
    Ok(())
}

fn continue_unless_set(stop: &AtomicBool) -> ControlFlow<()> {
    match stop.load(Ordering::Relaxed) {
        true => ControlFlow::Break(()),
        false => ControlFlow::Continue(()),
    }
}

/// Returns a flag that Ctrl-C and SIGTERM set; a second signal ends the process immediately.
fn stop_flag() -> Result<Arc<AtomicBool>> {
    shutdown::install_stop_flag(&shutdown::SIGNALS, shutdown::IMMEDIATE_EXIT)
        .map_err(Error::io("watch signals for", Path::new("this process")))
}
