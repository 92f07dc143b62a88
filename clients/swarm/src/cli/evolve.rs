//! `ebts evolve`: one run, with live progress, checkpoints and resumption.

use std::fmt::Write as _;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use clap::Args;
use indicatif::{ProgressBar, ProgressStyle};
use serde::Serialize;

use ebts::checkpoint::Checkpoint;
use ebts::condition::Setup;
use ebts::error::{Error, Result};
use ebts::evaluate::GoalPoints;
use ebts::files::sibling;
use ebts::run::{self, Rise, Run};
use ebts::table_file::TableFile;
use field::Engine;

use super::options::{EngineArgs, EvolutionArgs};
use super::{Format, answer, stop_flag};

/// How often a run under way is saved.
const SAVE_EVERY: Duration = Duration::from_secs(2);

#[derive(Debug, Args)]
pub(crate) struct EvolveArgs {
    #[command(flatten)]
    evolution: EvolutionArgs,
    #[command(flatten)]
    engine: EngineArgs,
    /// Agents on the field, 1 to 4.
    #[arg(long, default_value_t = 3)]
    agents: usize,
    /// Names the run: the same seed gives the same table, bit for bit.
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u64).range(..=i64::MAX as u64))]
    seed: u64,
    /// The table file to write; while the run goes on, its checkpoint lies beside it.
    #[arg(long, default_value = "table.toml")]
    out: PathBuf,
    /// Continue the interrupted run of this --out; all other settings come from its checkpoint.
    #[arg(long)]
    resume: bool,
    /// Replace a table file or a checkpoint that is there already.
    #[arg(long, conflicts_with = "resume")]
    overwrite: bool,
}

#[derive(Serialize)]
struct Evolved<'a> {
    table: &'a Path,
    agents: usize,
    seed: u64,
    generations: u32,
    fitness: f32,
    points: GoalPoints,
    rises: &'a [Rise],
    hash: String,
    wall_s: f64,
}

pub(super) fn evolve(args: EvolveArgs, format: Format) -> Result<()> {
    let start = Instant::now();
    let checkpoint_path = sibling(&args.out, ".checkpoint");
    let mut state = if args.resume {
        Checkpoint::read(&checkpoint_path)?
    } else {
        begin(&args, &checkpoint_path)?
    };
    let stop = stop_flag()?;
    let done = advance(&mut state, args.engine.engine()?, &checkpoint_path, &stop)?;
    if done.is_break() {
        let generation = state.run.generation().unwrap_or(0);
        let cure = format!("ebts evolve --out {} --resume", args.out.display());
        return Err(Error::Interrupted(format!(
            "interrupted: saved at generation {generation}; to go on run: {cure}"
        )));
    }
    let Some(record) = state.run.record(&state.condition) else {
        return Ok(());
    };
    let file = TableFile::from_record(&state.condition, &record, state.generations)?;
    file.write(&args.out)?;
    remove_if_there(&checkpoint_path)?;
    let evolved = Evolved {
        table: &args.out,
        agents: record.agents,
        seed: record.seed,
        generations: state.generations,
        fitness: record.fitness(),
        points: record.points,
        rises: &record.rises,
        hash: file.hash(),
        wall_s: start.elapsed().as_secs_f64(),
    };
    answer(format, &evolved, || {
        describe(&evolved, record.goals_solved())
    })
}

fn begin(args: &EvolveArgs, checkpoint: &Path) -> Result<Checkpoint> {
    if let (false, Some(there)) = (
        args.overwrite,
        [args.out.as_path(), checkpoint]
            .into_iter()
            .find(|path| path.exists()),
    ) {
        return Err(Error::refused(
            format_args!("write {}", args.out.display()),
            format_args!("{} is there already", there.display()),
            "a new name",
            "name another --out, continue with --resume, or replace it with --overwrite",
        ));
    }
    let preset = args.evolution.preset()?;
    let condition = Setup {
        agents: args.agents,
        sharing: args.evolution.sharing(),
        sensors: args.evolution.sensors(),
        fitness_rule: args.evolution.fitness_rule(&preset),
        preset,
    }
    .build()?;
    let (settings, islands) = (args.evolution.settings()?, args.evolution.islands());
    let run = Run::new(&condition, settings, islands, args.seed).map_err(Error::from_part)?;
    Ok(Checkpoint {
        condition,
        settings,
        islands,
        generations: args.evolution.generations,
        run,
    })
}

/// Evolves to the end or to the first signal, and keeps the checkpoint up to date.
fn advance(
    state: &mut Checkpoint,
    engine: Engine,
    path: &Path,
    stop: &AtomicBool,
) -> Result<ControlFlow<()>> {
    let bar = ProgressBar::new(u64::from(state.generations)).with_style(style("generation"));
    let (condition, generations) = (state.condition.clone(), state.generations);
    let mut saved_at = Instant::now();
    let mut failure = None;
    let mut runs = [state.run.clone()];
    let watch = |runs: &[Run]| {
        let run = &runs[0];
        bar.set_position(u64::from(run.generation().unwrap_or(0)));
        if let Some(rise) = run.rises().last() {
            bar.set_message(format!("best {:.1}", rise.fitness));
        }
        let stopped = stop.load(Ordering::Relaxed);
        if stopped || saved_at.elapsed() > SAVE_EVERY {
            let (settings, islands) = (state.settings, state.islands);
            let now = Checkpoint {
                condition: state.condition.clone(),
                settings,
                islands,
                generations,
                run: run.clone(),
            };
            failure = now.write(path).err();
            saved_at = Instant::now();
        }
        if stopped || failure.is_some() {
            ControlFlow::Break(())
        } else {
            ControlFlow::Continue(())
        }
    };
    let flow = run::evolve(&condition, engine, &mut runs, generations, watch);
    bar.finish_and_clear();
    let [run] = runs;
    state.run = run;
    failure.map_or(Ok(flow), Err)
}

/// The look of progress bars, on standard error.
pub(super) fn style(unit: &str) -> ProgressStyle {
    let template =
        format!("{{bar:30}} {unit} {{human_pos}} of {{human_len}}  {{msg}}  {{eta}} left");
    ProgressStyle::with_template(&template).unwrap_or_else(|_| ProgressStyle::default_bar())
}

fn remove_if_there(path: &Path) -> Result<()> {
    if path.exists() {
        std::fs::remove_file(path).map_err(Error::io("remove", path))
    } else {
        Ok(())
    }
}

fn describe(evolved: &Evolved<'_>, solved: usize) -> String {
    let mut text = format!(
        "{}: fitness {:.1} of 800, {solved} of 8 goals solved, after {} generations in {:.2} s\n",
        evolved.table.display(),
        evolved.fitness,
        evolved.generations,
        evolved.wall_s,
    );
    let points = evolved
        .points
        .map(|points| format!("{points:.1}"))
        .join("  ");
    let _ = writeln!(text, "points per goal: {points}\nhash {}", evolved.hash);
    text
}
