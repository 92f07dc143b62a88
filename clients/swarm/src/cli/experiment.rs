//! `ebts experiment`, `ebts merge`, `ebts analyse`: many runs and what they say.

use std::path::{Path, PathBuf};
use std::time::Instant;

use clap::{Args, ValueEnum};
use indicatif::ProgressBar;
use rayon::prelude::*;
use rustix::time::{ClockId, clock_gettime};
use serde::Serialize;

use ebts::analysis::{Baselines, Findings, HeldOut, baselines, findings, held_out};
use ebts::error::{Error, Result};
use ebts::experiment::{self, Plan, Progress, Shard, Store, Summary, read_folder, write_results};
use ebts::files::write_atomically;
use ebts::genome::Genome;
use ebts::plot::fig14;
use ebts::run::Record;
use ebts::stats::median;
use field::Engine;

use super::evolve::style;
use super::options::{EngineArgs, EvolutionArgs};
use super::report;
use super::{Format, answer, stop_flag};

#[derive(Debug, Args)]
pub(crate) struct ExperimentArgs {
    /// Which experiment.
    #[arg(value_enum)]
    name: Name,
    #[command(flatten)]
    evolution: EvolutionArgs,
    #[command(flatten)]
    engine: EngineArgs,
    /// Runs per team size; the paper made 10.
    #[arg(long, default_value_t = 80, value_parser = clap::value_parser!(u64).range(1..=1_000_000))]
    seeds: u64,
    /// The first seed; the others follow it.
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u64).range(..=i64::MAX as u64 / 2))]
    first_seed: u64,
    /// Do only part i of n of the runs, for ebts merge.
    #[arg(long, value_name = "i/n")]
    shard: Option<Shard>,
    /// Folder of the experiment [default: made from its name, preset, seeds and generations]. A folder with the same
    /// experiment is continued, one with another is refused.
    #[arg(long)]
    out: Option<PathBuf>,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum Name {
    /// One to four agents, maximum fitness over generations (paper Fig. 14).
    Fig14,
}

#[derive(Debug, Args)]
pub(crate) struct MergeArgs {
    /// Folder to collect the runs in.
    out: PathBuf,
    /// Folders of the shards.
    #[arg(required = true)]
    shards: Vec<PathBuf>,
}

#[derive(Debug, Args)]
pub(crate) struct AnalyseArgs {
    /// Folder of an experiment.
    folder: PathBuf,
    #[command(flatten)]
    engine: EngineArgs,
    /// Random tables per team size to compare with.
    #[arg(long, default_value_t = 1000)]
    random_tables: usize,
}

/// Wall and processor time since the process began to work.
struct Stopwatch(Instant);

impl Stopwatch {
    fn wall_s(&self) -> f64 {
        self.0.elapsed().as_secs_f64()
    }

    fn cpu_s() -> f64 {
        let spent = clock_gettime(ClockId::ProcessCPUTime);
        spent.tv_sec as f64 + spent.tv_nsec as f64 * 1e-9
    }
}

pub(super) fn experiment(args: ExperimentArgs, format: Format) -> Result<()> {
    let watch = Stopwatch(Instant::now());
    let Name::Fig14 = args.name;
    let plan = plan(&args)?;
    let shard = args.shard.unwrap_or(Shard::WHOLE);
    let jobs = shard.select(plan.jobs());
    let folder = args
        .out
        .clone()
        .unwrap_or_else(|| default_folder(&plan, shard));
    plan.conditions()?;
    let (mut store, records) = Store::open(&folder, &plan)?;
    let before = records.len();
    let bar = ProgressBar::new(jobs.len() as u64 * u64::from(plan.generations))
        .with_style(style("generation"));
    bar.set_position(before as u64 * u64::from(plan.generations));
    let progress = |progress| match progress {
        Progress::Generations(count) => bar.inc(count),
        Progress::Finished(job, fitness) => bar.set_message(format!(
            "{} agents, seed {}: {fitness:.1}",
            job.agents, job.seed
        )),
    };
    let engine = (args.engine.engine()?, args.engine.threads());
    let records = experiment::execute(
        &plan,
        &jobs,
        (&mut store, records),
        engine,
        &*stop_flag()?,
        progress,
    );
    bar.finish_and_clear();
    let records = records?;
    let note = (before > 0)
        .then(|| format!("{before} of these runs were there already; the times are of the rest"));
    conclude(&folder, &plan, &records, &watch, note, format)
}

fn plan(args: &ExperimentArgs) -> Result<Plan> {
    let preset = args.evolution.preset()?;
    let fitness_rule = args.evolution.fitness_rule(&preset);
    Ok(Plan {
        first_seed: args.first_seed,
        sharing: args.evolution.sharing(),
        sensors: args.evolution.sensors(),
        settings: args.evolution.settings()?,
        islands: args.evolution.islands(),
        ..Plan::fig14(preset, fitness_rule, args.seeds, args.evolution.generations)
    })
}

fn default_folder(plan: &Plan, shard: Shard) -> PathBuf {
    let Shard { index, count } = shard;
    let part = if shard == Shard::WHOLE {
        String::new()
    } else {
        format!("-{index}of{count}")
    };
    PathBuf::from(format!(
        "fig14-{}-{}x{}{part}",
        plan.preset.name, plan.seeds, plan.generations
    ))
}

/// Writes everything that is derived from the runs, and prints the summary.
fn conclude(
    folder: &Path,
    plan: &Plan,
    records: &[Record],
    watch: &Stopwatch,
    note: Option<String>,
    format: Format,
) -> Result<()> {
    let findings = findings(plan, records)?;
    write_results(folder, plan, records, &findings)?;
    let figure = folder.join("fig14.svg");
    write_atomically(&figure, fig14(plan, records)?.as_bytes())?;
    let summary = Summary::new(plan, records, &findings, watch.wall_s(), Stopwatch::cpu_s());
    let json = serde_json::to_string_pretty(&summary).map_err(Error::from_part)?;
    write_atomically(&folder.join("summary.json"), json.as_bytes())?;
    answer(format, &summary, || {
        let note = note.map_or_else(String::new, |note| format!("{note}\n"));
        format!(
            "{}{note}{}figure: {}\n",
            report::summary(&summary),
            report::findings(&findings),
            figure.display()
        )
    })
}

pub(super) fn merge(args: MergeArgs, format: Format) -> Result<()> {
    let watch = Stopwatch(Instant::now());
    let shards: Vec<&Path> = args.shards.iter().map(PathBuf::as_path).collect();
    let merged = experiment::merge(&args.out, &shards)?;
    let note = (merged.missing > 0).then(|| {
        let out = args.out.display();
        format!(
            "{} runs are missing; merge their shards too, or run the experiment with --out {out}",
            merged.missing
        )
    });
    conclude(
        &args.out,
        &merged.plan,
        &merged.records,
        &watch,
        note,
        format,
    )
}

/// What evolution reached for one team size, and what it has to beat.
#[derive(Serialize)]
pub(super) struct Comparison {
    pub(super) agents: usize,
    pub(super) evolved_median: f32,
    pub(super) baselines: Baselines,
    /// Medians over the runs.
    pub(super) held_out: HeldOut,
}

#[derive(Serialize)]
struct Analysis {
    preset: String,
    findings: Findings,
    comparisons: Vec<Comparison>,
}

pub(super) fn analyse(args: AnalyseArgs, format: Format) -> Result<()> {
    let (plan, records) = read_folder(&args.folder)?;
    let engine = args.engine.engine()?;
    let analysis = Analysis {
        preset: plan.preset.name.to_string(),
        findings: findings(&plan, &records)?,
        comparisons: comparisons(&plan, &records, engine, args.random_tables)?,
    };
    answer(format, &analysis, || {
        let header = format!("preset {}, {} runs\n", analysis.preset, records.len());
        header + &report::findings(&analysis.findings) + &report::comparisons(&analysis.comparisons)
    })
}

fn comparisons(
    plan: &Plan,
    records: &[Record],
    engine: Engine,
    random_tables: usize,
) -> Result<Vec<Comparison>> {
    let conditions = plan.conditions()?;
    let compare = |condition: &ebts::condition::Condition| {
        let agents = condition.team.get();
        let runs: Vec<&Record> = records
            .iter()
            .filter(|record| record.agents == agents)
            .collect();
        let genomes = runs
            .iter()
            .filter_map(|run| Genome::from_hex(condition.genome_bits(), &run.genome));
        let held: Vec<HeldOut> = genomes
            .map(|genome| held_out(condition, engine, &genome))
            .collect();
        let of = |part: fn(&HeldOut) -> f32| median(&held.iter().map(part).collect::<Vec<_>>());
        Comparison {
            agents,
            evolved_median: median(&runs.iter().map(|run| run.fitness()).collect::<Vec<_>>()),
            baselines: baselines(condition, engine, random_tables),
            held_out: HeldOut {
                training: of(|held| held.training),
                goals: of(|held| held.goals),
                starts: of(|held| held.starts),
                goals_and_starts: of(|held| held.goals_and_starts),
            },
        }
    };
    Ok(conditions.par_iter().map(compare).collect())
}
