//! `ebts experiment grasp`: many runs and the verdict on their tables.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;
use std::time::Instant;

use atas_core::tasks::BehaviourTable;
use clap::Args;
use indicatif::ProgressBar;
use rayon::prelude::*;
use serde::Serialize;

use ebts::error::{Error, Result};
use ebts::experiment::Shard;
use ebts::files::write_atomically;
use ebts::grasp::course::{self, Family};
use ebts::grasp::description::{ModuleMatch, ModuleMatches, match_modules};
use ebts::grasp::evolve::evaluate_table;
use ebts::grasp::figure;
use ebts::grasp::table_file::GraspFile;
use ebts::grasp::verdict::{self, PolicyScores, Score};
use ebts::run::Job;
use ebts::workers::pool;

use super::evolve::{EvolutionArgs, run};
use super::{Format, answer, stop_flag, style};

/// First seed of the family members of the verdict; they are used neither in evolution nor tuning.
const VERDICT_FIRST_SEED: u64 = 7_600_001;

#[derive(Debug, Args)]
#[command(after_help = "Examples:
  ebts experiment grasp --seeds 20 --out grasp
  ebts experiment grasp --seeds 20 --shard 1/2 --out grasp
  ebts experiment grasp --seeds 20 --members 5 --out grasp --format json")]
pub(crate) struct ExperimentGraspArgs {
    #[command(flatten)]
    evolution: EvolutionArgs,
    /// Runs of the genetic algorithm.
    #[arg(long, default_value_t = 20, value_parser = clap::value_parser!(u64).range(1..=100_000))]
    seeds: u64,
    /// First seed; the others follow it.
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u64).range(..=i64::MAX as u64 / 2))]
    first_seed: u64,
    /// Evolve only part i of n of the runs, without verdict.
    ///
    /// Shards are merged by copying their files into one folder.
    #[arg(long, value_name = "i/n")]
    shard: Option<Shard>,
    /// Folder with one table file per run; existing runs are verified instead of repeated.
    #[arg(long, default_value = "grasp")]
    out: PathBuf,
    /// Members of each of the eight object families for the verdict.
    #[arg(long, default_value_t = 5, value_parser = clap::value_parser!(u64).range(1..=10_000))]
    members: u64,
    /// Threads; all cores by default.
    #[arg(long, default_value_t = 0)]
    threads: usize,
}

#[derive(Serialize)]
struct Verdict {
    /// Score of the fittest table in the reduced simulation, chosen without the verdict.
    table: Score,
    tables_success_median: f64,
    /// Best success of the tables, chosen with the verdict.
    tables_success_best: f64,
    /// Number of tables that correspond to each module in every row to which it applies.
    again: Vec<(&'static str, usize)>,
    #[serde(flatten)]
    judged: PolicyScores,
    seeds: u64,
    members: u64,
    members_from: u64,
    generations: u32,
    wall_s: f64,
}

pub(in crate::cli) fn experiment(args: &ExperimentGraspArgs, format: Format) -> Result<()> {
    let start = Instant::now();
    let (families, stop) = (course::families()?, stop_flag()?);
    std::fs::create_dir_all(&args.out).map_err(Error::io("create folder", &args.out))?;
    let threads = match args.threads {
        0 => std::thread::available_parallelism().map_or(1, usize::from),
        threads => threads,
    };
    let mut tables = pool(threads)?.install(|| runs(args, &families, &stop))?;
    if args.shard.is_some() {
        return answer(format, &tables.len(), || {
            format!("{} runs are in {}\n", tables.len(), args.out.display())
        });
    }
    tables.sort_by(|(a, _), (b, _)| {
        b.fitness()
            .total_cmp(&a.fitness())
            .then(a.seed.cmp(&b.seed))
    });
    let candidates: Vec<_> = tables
        .iter()
        .map(|(file, table)| (*table, file.seed, file.fitness()))
        .collect();
    let bar =
        ProgressBar::new(verdict::jobs(tables.len(), args.members)).with_style(style("grasp"));
    let members = (args.members, VERDICT_FIRST_SEED);
    let judged = verdict::evaluate(&candidates, members, threads, &stop, || bar.inc(1))?;
    bar.finish_and_clear();
    let judged = judged.ok_or_else(|| {
        Error::Interrupted(
            "interrupted: all runs are saved; run the command again to repeat the verdict"
                .to_owned(),
        )
    })?;
    let figure_path = args.out.join("verdict.svg");
    figure::draw(&judged, &figure_path)?;
    let found = conclude(args, &families, &tables, judged, start)?;
    let text = serde_json::to_string_pretty(&found).map_err(Error::from_part)?;
    write_atomically(&args.out.join("verdict.json"), text.as_bytes())?;
    answer(format, &found, || describe(&found, &figure_path))
}

fn runs(
    args: &ExperimentGraspArgs,
    families: &[Family],
    stop: &AtomicBool,
) -> Result<Vec<(GraspFile, BehaviourTable)>> {
    let jobs = (args.first_seed..args.first_seed + args.seeds).map(|seed| Job { agents: 1, seed });
    let jobs = args.shard.unwrap_or(Shard::WHOLE).select(jobs.collect());
    let bar = ProgressBar::new(jobs.len() as u64).with_style(style("run"));
    let one = |job: &Job| {
        let path = args.out.join(format!("seed-{}.toml", job.seed));
        if !path.exists() {
            let (file, _) = run(families, &args.evolution, job.seed, stop, |_, _| ())?;
            file.write(&path)?;
        }
        let (file, table) = GraspFile::read(&path, families)?;
        let evolution = &args.evolution;
        if (file.generations, file.force_limit, file.seed)
            != (evolution.generations, evolution.with_module_3, job.seed)
        {
            return Err(Error::refused(
                format_args!("use {}", path.display()),
                format_args!(
                    "it is of another experiment: seed {}, {} generations",
                    file.seed, file.generations
                ),
                "runs of the same settings in one folder",
                "choose another --out",
            ));
        }
        bar.inc(1);
        Ok((file, table))
    };
    let tables = jobs.par_iter().with_max_len(1).map(one).collect();
    bar.finish_and_clear();
    tables
}

fn conclude(
    args: &ExperimentGraspArgs,
    families: &[Family],
    tables: &[(GraspFile, BehaviourTable)],
    judged: PolicyScores,
    start: Instant,
) -> Result<Verdict> {
    let success: Vec<f64> = judged
        .tables
        .iter()
        .map(|table| table.score.success)
        .collect();
    let best = success
        .iter()
        .fold(0.0, |best: f64, success| best.max(*success));
    let first = judged.tables.first().map(|table| table.score.clone());
    let words: Vec<ModuleMatches> = tables
        .iter()
        .filter_map(|(file, table)| Some((file, table, course::genome(table)?)))
        .map(|(file, table, genome)| {
            let (_, read, _) = evaluate_table(families, &genome, file.force_limit);
            match_modules(table, read)
        })
        .collect();
    let whole = |get: fn(&ModuleMatches) -> ModuleMatch| {
        let found = |again: &&ModuleMatches| {
            get(again).asked > 0 && get(again).answered == get(again).asked
        };
        words.iter().filter(found).count()
    };
    Ok(Verdict {
        table: first.ok_or_else(|| Error::from_part("there is no table"))?,
        tables_success_median: atas_evaluation::median(success).unwrap_or(0.0),
        tables_success_best: best,
        again: vec![
            ("module 1", whole(|again| again.module_1)),
            ("module 2", whole(|again| again.module_2)),
            ("module 3", whole(|again| again.module_3)),
            ("refusing", whole(|again| again.refusing)),
            ("giving back", whole(|again| again.giving_back)),
        ],
        judged,
        seeds: args.seeds,
        members: args.members,
        members_from: VERDICT_FIRST_SEED,
        generations: args.evolution.generations,
        wall_s: start.elapsed().as_secs_f64(),
    })
}

fn describe(found: &Verdict, figure: &Path) -> String {
    let mut text = format!(
        " {:<32} success [95 %]           held  refused  crushed  over-grip  time s  by physics\n",
        format!("{} members of 8 families", found.members)
    );
    let mut row = |name: &str, score: &Score| {
        let number =
            |value: Option<f64>| value.map_or("-".to_owned(), |value| format!("{value:.2}"));
        let _ = writeln!(
            text,
            " {name:<32} {:>5.1} % [{:>4.1}, {:>5.1}]   {:>5} {:>8} {:>8} {:>10} {:>7} {:>9.1} %",
            score.success * 100.0,
            score.ci95[0] * 100.0,
            score.ci95[1] * 100.0,
            score.held,
            score.refused,
            score.crushed,
            number(score.over_grip_median),
            number(score.time_median_s),
            score.success_by_physics * 100.0
        );
    };
    let judged = &found.judged;
    row("fittest evolved table", &found.table);
    row("fittest table with Module 3", &judged.with_module_3);
    row("the paper's rules as a table", &judged.rules);
    row("hand-written modules", &judged.modules);
    for (module, score) in &judged.without {
        row(&format!("  without {module}"), score);
    }
    row("slip-reactive baseline", &judged.slip_reactive);
    row("fixed-force baseline", &judged.fixed_force);
    let _ = writeln!(
        text,
        "\n{} tables: success median {:.1} %, best {:.1} %; figure: {}",
        judged.tables.len(),
        found.tables_success_median * 100.0,
        found.tables_success_best * 100.0,
        figure.display()
    );
    let again: Vec<String> = found
        .again
        .iter()
        .map(|(module, tables)| format!("{module} by {tables}"))
        .collect();
    let _ = writeln!(
        text,
        "Tables that correspond to a module in every applicable row: {}",
        again.join(", ")
    );
    text
}
