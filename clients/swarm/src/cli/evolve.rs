//! `ebts evolve`: one run with progress display, checkpoints and resumption.

use std::fmt::Write as _;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use clap::{Args, Subcommand};
use indicatif::ProgressBar;
use serde::Serialize;

use ebts::checkpoint::Checkpoint;
use ebts::condition::Setup;
use ebts::error::{Error, Result};
use ebts::evaluate::GoalPoints;
use ebts::files::{remove_if_exists, sibling};
use ebts::run::{self, GenerationStatistics, Rise, Run};
use ebts::scoring::Scoring;
use ebts::table_file::TableFile;
use ebts::workers::Workers;

use super::options::{EngineArgs, EvolutionArgs, csv_file, toml_file};
use super::progress::style;
use super::{Format, answer, course, grasp, stop_flag};

const SAVE_EVERY: Duration = Duration::from_secs(2);

const EXAMPLES: &str = "Examples:
  ebts evolve --agents 2 --seed 71 --out mine.toml
  ebts evolve --agents 2 --seed 71 --out mine.toml --resume
  ebts evolve --preset LB3 --fitness compared --out mine.toml --history mine.csv";

#[derive(Debug, Args)]
#[command(after_help = EXAMPLES, args_conflicts_with_subcommands = true)]
pub(crate) struct EvolveArgs {
    #[command(subcommand)]
    task: Option<Task>,
    #[command(flatten)]
    evolution: EvolutionArgs,
    #[command(flatten)]
    engine: EngineArgs,
    /// Agents on the field, 1 to 4.
    #[arg(long, default_value_t = 3)]
    agents: usize,
    /// Seed of the run: the same seed gives the same table, bit for bit.
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u64).range(..=i64::MAX as u64))]
    seed: u64,
    /// Table file to write; during the run its checkpoint is in the same folder.
    #[arg(long, value_name = "FILE.toml", default_value = "table.toml", value_parser = toml_file)]
    out: PathBuf,
    /// Continue the interrupted run of this --out; all other settings come from its checkpoint.
    #[arg(long)]
    resume: bool,
    /// CSV file with statistics of every generation.
    ///
    /// Columns: best, mean and worst fitness, and diversity. With --resume it begins at the resumed
    /// generation.
    #[arg(long, value_name = "FILE.csv", value_parser = csv_file)]
    history: Option<PathBuf>,
    /// Replace an existing table file or checkpoint.
    #[arg(long, conflicts_with = "resume")]
    overwrite: bool,
}

#[derive(Debug, Subcommand)]
enum Task {
    /// Evolve a grasp table: a hand grasps eight families of objects.
    Grasp(grasp::EvolveGraspArgs),
    /// Evolve a course table: a robot with hands fetches an object and carries it to a goal.
    Course(course::EvolveCourseArgs),
}

#[derive(Serialize)]
struct Evolved<'a> {
    table: &'a Path,
    agents: usize,
    seed: u64,
    generations: u32,
    fitness_rule: &'a Scoring,
    fitness: f32,
    points: GoalPoints,
    rises: &'a [Rise],
    hash: String,
    wall_s: f64,
}

pub(super) fn evolve(args: EvolveArgs, format: Format) -> Result<()> {
    match &args.task {
        Some(Task::Grasp(args)) => return grasp::evolve(args, format),
        Some(Task::Course(args)) => return course::evolve(args, format),
        None => {}
    }
    let start = Instant::now();
    let checkpoint_path = sibling(&args.out, ".checkpoint");
    let mut state = if args.resume {
        Checkpoint::read(&checkpoint_path)?
    } else {
        begin(&args, &checkpoint_path)?
    };
    let workers = args.engine.workers(stop_flag()?)?;
    let mut history = args.history.as_deref().map(History::begin).transpose()?;
    let done = advance(&mut state, &workers, &checkpoint_path, history.as_mut())?;
    if done.is_break() {
        let generation = state.run.generation().unwrap_or(0);
        let cure = format!("ebts evolve --out {} --resume", args.out.display());
        return Err(Error::Interrupted(format!(
            "interrupted: saved at generation {generation}; to continue run: {cure}"
        )));
    }
    let Some(record) = state.run.record(&state.condition) else {
        return Ok(());
    };
    let file = TableFile::from_record(&state.condition, &record, state.generations)?;
    file.write(&args.out)?;
    remove_if_exists(&checkpoint_path)?;
    let evolved = Evolved {
        table: &args.out,
        agents: record.agents,
        seed: record.seed,
        generations: state.generations,
        fitness_rule: &state.condition.fitness,
        fitness: record.fitness(),
        points: record.points,
        rises: &record.rises,
        hash: file.hash(),
        wall_s: start.elapsed().as_secs_f64(),
    };
    answer(format, &evolved, || {
        describe(&evolved, record.full_scores())
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
            format_args!("{} exists already", there.display()),
            "a new name",
            "choose another --out, continue with --resume, or replace it with --overwrite",
        ));
    }
    let preset = args.evolution.preset()?;
    let condition = Setup {
        agents: args.agents,
        sharing: args.evolution.sharing(),
        sensors: args.evolution.sensors(),
        fitness_rule: args.evolution.fitness_rule(&preset).into(),
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

fn advance(
    state: &mut Checkpoint,
    workers: &Workers,
    path: &Path,
    mut history: Option<&mut History>,
) -> Result<ControlFlow<()>> {
    let bar = ProgressBar::new(u64::from(state.generations)).with_style(style("generation"));
    let (condition, generations) = (state.condition.clone(), state.generations);
    let (mut saved_at, mut failure) = (Instant::now(), Ok(()));
    let mut runs = [state.run.clone()];
    let watch = |runs: &[Run]| {
        let run = &runs[0];
        bar.set_position(u64::from(run.generation().unwrap_or(0)));
        if let Some(rise) = run.rises().last() {
            bar.set_message(format!("best {:.1}", rise.fitness));
        }
        if let (Some(history), Some(census)) = (&mut history, run.statistics()) {
            failure = history.add(&census);
        }
        if failure.is_ok() && saved_at.elapsed() > SAVE_EVERY {
            failure = with(state, run).write(path);
            saved_at = Instant::now();
        }
        match workers.is_stopped() || failure.is_err() {
            true => ControlFlow::Break(()),
            false => ControlFlow::Continue(()),
        }
    };
    let flow = run::evolve(&condition, workers.clone(), &mut runs, generations, watch);
    bar.finish_and_clear();
    failure?;
    *state = with(state, &runs[0]);
    if flow.is_break() {
        state.write(path)?;
    }
    history.map_or(Ok(()), History::end)?;
    Ok(flow)
}

fn with(state: &Checkpoint, run: &Run) -> Checkpoint {
    Checkpoint {
        run: run.clone(),
        ..state.clone()
    }
}

struct History {
    path: PathBuf,
    rows: csv::Writer<std::fs::File>,
}

impl History {
    fn begin(path: &Path) -> Result<Self> {
        let file = std::fs::File::create(path).map_err(Error::io("write", path))?;
        let (path, rows) = (path.to_owned(), csv::Writer::from_writer(file));
        Ok(Self { path, rows })
    }

    fn add(&mut self, census: &GenerationStatistics) -> Result<()> {
        let written = self.rows.serialize(census);
        written.map_err(|error| Error::io("write", &self.path)(error.into()))
    }

    fn end(&mut self) -> Result<()> {
        self.rows.flush().map_err(Error::io("write", &self.path))
    }
}

fn describe(evolved: &Evolved<'_>, solved: usize) -> String {
    let mut text = format!(
        "{}: fitness {:.1} of 800 by the rule {}, {solved} of 8 goals in full\n\
         {} generations in {:.2} s\n",
        evolved.table.display(),
        evolved.fitness,
        evolved.fitness_rule,
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
