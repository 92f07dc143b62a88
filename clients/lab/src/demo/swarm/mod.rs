//! `atas demo swarm`: a team of robots on a field process, each driven by an evolved table in a
//! separate process.
//!
//! The bus carries the same data as the simulation during evolution. Without missed frames, the
//! points of every goal equal those in the table file; the demo checks this.

mod arena;
mod report;

use anyhow::Context;
use atas_console::arguments::DemoSwarm;
use atas_console::{Exit, ExitError, Interrupt, Output, Progress};
use ebts::built_in;
use ebts::table_file::TableFile;

use arena::Arena;
use report::Report;

pub(crate) fn swarm(
    arguments: &DemoSwarm,
    interrupt: &Interrupt,
    output: &mut Output,
) -> anyhow::Result<()> {
    let file = built_in::table(&arguments.table)
        .map_err(|error| ExitError::with_code(Exit::Usage, error.to_string()))?;
    let mut progress = Progress::new("swarm");
    progress.show_activity("starting atas-sim field and ebts agents");
    let arena = Arena::start(arguments, &file, interrupt, &mut progress)?;
    let trials = arena.watch(interrupt, &mut progress)?;
    drop(progress);
    if let Some(path) = &arguments.replay {
        write_replay(&file, path)?;
    }
    let report = Report {
        table: &arguments.table,
        file: &file,
        trials: &trials,
        replay: arguments.replay.as_deref(),
    };
    report.print(output)?;
    report.verdict()
}

fn write_replay(file: &TableFile, path: &std::path::Path) -> anyhow::Result<()> {
    let page = ebts::replay::page(file)?;
    std::fs::write(path, page).with_context(|| format!("could not write {}", path.display()))
}
