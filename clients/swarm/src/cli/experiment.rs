//! `ebts experiment` and `ebts merge`: many runs and their results.

use std::path::{Path, PathBuf};
use std::time::Instant;

use clap::{Args, Subcommand, ValueEnum};
use indicatif::ProgressBar;
use rustix::time::{ClockId, clock_gettime};

use ebts::analysis::findings;
use ebts::error::{Error, Result};
use ebts::experiment::{self, Plan, Progress, Shard, Store};
use ebts::files::{plain_name, write_atomically};
use ebts::plot::fig14;
use ebts::results::{Summary, write_results, write_summary};
use ebts::run::Record;
use ebts::workers::{Workers, pool};
use field::Preset;

use super::options::{EngineArgs, EvolutionArgs};
use super::progress::style;
use super::report;
use super::{Format, answer, grasp, stop_flag, warn};

const EXAMPLES: &str = "Examples:
  ebts experiment fig14 --seeds 80 --out fig14
  ebts experiment fig14 --preset N3 --fitness compared --seeds 320
  ebts experiment fig14 --agents 1,4 --seeds 20
  ebts experiment fig14 --seeds 80 --shard 1/2 --out a";

#[derive(Debug, Args)]
#[command(after_help = EXAMPLES, args_conflicts_with_subcommands = true)]
pub(crate) struct ExperimentArgs {
    #[command(subcommand)]
    task: Option<Task>,
    /// Experiment.
    #[arg(value_enum, required = true)]
    name: Option<Name>,
    #[command(flatten)]
    pub(super) runs: RunsArgs,
    /// Run only part i of n, for ebts merge.
    #[arg(long, value_name = "i/n")]
    shard: Option<Shard>,
    /// Folder of the experiment [default: derived from its settings].
    ///
    /// A folder with the same experiment is continued; one with another experiment is rejected.
    #[arg(long)]
    out: Option<PathBuf>,
}

impl ExperimentArgs {
    /// Returns whether this is a grasp experiment, whose runs are merged differently.
    pub(super) fn is_of_grasps(&self) -> bool {
        matches!(self.task, Some(Task::Grasp(_)))
    }
}

#[derive(Debug, Args)]
pub(super) struct RunsArgs {
    #[command(flatten)]
    pub(super) evolution: EvolutionArgs,
    #[command(flatten)]
    pub(super) engine: EngineArgs,
    /// Team sizes.
    #[arg(
        long,
        value_delimiter = ',',
        default_value = "1,2,3,4",
        value_name = "N,..."
    )]
    agents: Vec<usize>,
    /// Runs per team size; the paper has 10.
    #[arg(long, default_value_t = 80, value_parser = clap::value_parser!(u64).range(1..=1_000_000))]
    seeds: u64,
    /// First seed; the others follow it.
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u64).range(..=i64::MAX as u64 / 2))]
    first_seed: u64,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum Name {
    /// One to four agents, maximum fitness over generations (paper Fig. 14).
    Fig14,
}

#[derive(Debug, Subcommand)]
enum Task {
    /// Evolve grasp tables and evaluate them in the full simulation.
    ///
    /// The results are compared with hand-written modules and baselines.
    Grasp(grasp::ExperimentGraspArgs),
}

#[derive(Debug, Args)]
#[command(after_help = "Examples:\n  ebts merge whole a b\n  ebts merge --partial so-far a")]
pub(crate) struct MergeArgs {
    /// Folder to collect the runs in.
    out: PathBuf,
    /// Folders of the shards.
    #[arg(required = true)]
    shards: Vec<PathBuf>,
    /// Conclude from the existing runs even if others are missing.
    #[arg(long)]
    partial: bool,
}

/// Wall and CPU time since the start of the work.
pub(super) struct Stopwatch(Instant);

impl Stopwatch {
    pub(super) fn start() -> Self {
        Self(Instant::now())
    }

    fn wall_s(&self) -> f64 {
        self.0.elapsed().as_secs_f64()
    }

    fn cpu_s() -> f64 {
        let spent = clock_gettime(ClockId::ProcessCPUTime);
        spent.tv_sec as f64 + spent.tv_nsec as f64 * 1e-9
    }
}

pub(super) fn experiment(args: ExperimentArgs, format: Format) -> Result<()> {
    let watch = Stopwatch::start();
    if let Some(Task::Grasp(args)) = args.task {
        return grasp::experiment(&args, format);
    }
    let plan = args.runs.plan(args.runs.evolution.preset()?)?;
    let shard = args.shard.unwrap_or(Shard::WHOLE);
    let folder = args
        .out
        .clone()
        .unwrap_or_else(|| default_folder(&plan, shard));
    let engine = &args.runs.engine;
    let workers = (&engine.workers(stop_flag()?)?, engine.threads());
    let (records, before) = run(&plan, shard, &folder, workers, &ProgressBar::new(0))?;
    let note = (before > 0)
        .then(|| format!("{before} of these runs existed already; the times are of the others"));
    let threads = args.runs.engine.threads();
    let summary = pool(threads)?.install(|| conclude(&folder, &plan, &records, &watch))?;
    print_summary(&folder, &summary, note, format)
}

impl RunsArgs {
    pub(super) fn plan(&self, preset: Preset) -> Result<Plan> {
        let plan = Plan {
            agents: self.agents.clone(),
            first_seed: self.first_seed,
            ..self.evolution.plan(preset, self.seeds)?
        };
        plan.conditions().map(|_| plan)
    }
}

/// Runs the missing jobs; returns all records and the number of earlier ones.
pub(super) fn run(
    plan: &Plan,
    shard: Shard,
    folder: &Path,
    (workers, threads): (&Workers, usize),
    bar: &ProgressBar,
) -> Result<(Vec<Record>, usize)> {
    let jobs = shard.select(plan.jobs());
    let (mut store, records) = Store::open(folder, plan)?;
    let before = records.len();
    bar.set_length(jobs.len() as u64 * u64::from(plan.generations));
    bar.set_style(style("generation"));
    bar.set_position(before as u64 * u64::from(plan.generations));
    let progress = |progress| match progress {
        Progress::Generations(count) => bar.inc(count),
        Progress::Finished(job, fitness) => bar.set_message(format!(
            "{} agents, seed {}: {fitness:.1}",
            job.agents, job.seed
        )),
        Progress::Restarted { job, why, kept } => bar.suspend(|| {
            warn(format_args!(
                "{} agents, seed {}: restarted because {why}; the file is kept as {}",
                job.agents,
                job.seed,
                kept.display()
            ));
        }),
    };
    let records = experiment::execute(
        plan,
        &jobs,
        (&mut store, records),
        (workers, threads),
        progress,
    );
    bar.finish_and_clear();
    Ok((records?, before))
}

fn default_folder(plan: &Plan, shard: Shard) -> PathBuf {
    let Shard { index, count } = shard;
    let part = if shard == Shard::WHOLE {
        String::new()
    } else {
        format!("-{index}of{count}")
    };
    let rule = if plan.fitness_rule == field::FitnessRule::default_for(&plan.preset) {
        String::new()
    } else {
        format!("-{}", plan.fitness_rule)
    };
    PathBuf::from(plain_name(&format!(
        "fig14-{}{rule}-{}x{}{part}",
        plan.preset.name, plan.seeds, plan.generations
    )))
}

pub(super) fn conclude(
    folder: &Path,
    plan: &Plan,
    records: &[Record],
    watch: &Stopwatch,
) -> Result<(Summary, ebts::analysis::Findings)> {
    let findings = findings(plan, records)?;
    write_results(folder, plan, records, &findings)?;
    write_atomically(&folder.join("fig14.svg"), fig14(plan, records)?.as_bytes())?;
    let summary = Summary::new(plan, records, &findings, watch.wall_s(), Stopwatch::cpu_s());
    write_summary(folder, &summary)?;
    Ok((summary, findings))
}

fn print_summary(
    folder: &Path,
    (summary, findings): &(Summary, ebts::analysis::Findings),
    note: Option<String>,
    format: Format,
) -> Result<()> {
    answer(format, summary, || {
        let note = note.map_or_else(String::new, |note| format!("{note}\n"));
        format!(
            "{}{note}{}figure: {}\n",
            report::summary(summary),
            report::findings(findings),
            folder.join("fig14.svg").display()
        )
    })
}

pub(super) fn merge(args: MergeArgs, format: Format) -> Result<()> {
    let watch = Stopwatch::start();
    let shards: Vec<&Path> = args.shards.iter().map(PathBuf::as_path).collect();
    let merged = experiment::merge(&args.out, &shards)?;
    if merged.records.is_empty() {
        return Err(Error::refused(
            "merge",
            "no shard has a finished run",
            "one or more",
            "run the shards first",
        ));
    }
    let out = args.out.display();
    match (merged.missing.is_empty(), args.partial) {
        (true, _) => {}
        (false, true) => warn(format_args!("{out} lacks {}", merged.missing)),
        (false, false) => {
            return Err(Error::refused(
                format_args!("conclude from {out}"),
                format_args!("it lacks {}", merged.missing),
                "every run of the plan",
                format_args!(
                    "merge the missing shards too, run the experiment with --out {out} (merged \
                     runs are kept), or add --partial"
                ),
            ));
        }
    }
    let summary = conclude(&args.out, &merged.plan, &merged.records, &watch)?;
    print_summary(&args.out, &summary, None, format)
}
