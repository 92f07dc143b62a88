//! `ebts evolve grasp`: one run.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;
use std::time::Instant;

use clap::Args;
use indicatif::ProgressBar;
use pinch::Engine;
use serde::Serialize;

use ebts::error::Result;
use ebts::evaluate::GoalPoints;
use ebts::ga::Settings;
use ebts::grasp::course::{self, Family};
use ebts::grasp::evolve::{Evaluator, evolve as evolve_one};
use ebts::grasp::table_file::GraspFile;

use super::{Format, answer, check_overwrite, continue_unless_set, stop_flag, style, toml_file};

#[derive(Debug, Args)]
pub(super) struct EvolutionArgs {
    /// Generations after the random population.
    #[arg(long, default_value_t = 2000)]
    pub(super) generations: u32,
    /// Keep Module 3 active during evolution; otherwise the table must replace it.
    #[arg(long)]
    pub(super) with_module_3: bool,
}

#[derive(Debug, Args)]
#[command(after_help = "Example:\n  ebts evolve grasp --seed 3 --out mine-grasp.toml")]
pub(crate) struct EvolveGraspArgs {
    #[command(flatten)]
    evolution: EvolutionArgs,
    /// Seed of the run: the same seed gives the same table, bit for bit.
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u64).range(..=i64::MAX as u64))]
    seed: u64,
    /// Table file to write.
    #[arg(long, value_name = "FILE.toml", default_value = "grasp.toml", value_parser = toml_file)]
    out: PathBuf,
    /// Replace an existing table file.
    #[arg(long)]
    overwrite: bool,
}

#[derive(Serialize)]
struct Evolved<'a> {
    table: &'a Path,
    seed: u64,
    generations: u32,
    fitness: f32,
    points: GoalPoints,
    grasps_simulated: u64,
    hash: &'a str,
    wall_s: f64,
}

pub(in crate::cli) fn evolve(args: &EvolveGraspArgs, format: Format) -> Result<()> {
    let start = Instant::now();
    check_overwrite(&args.out, args.overwrite)?;
    let (families, stop) = (course::families()?, stop_flag()?);
    let bar = ProgressBar::new(args.evolution.generations.into()).with_style(style("generation"));
    let (file, simulated) = run(
        &families,
        &args.evolution,
        args.seed,
        &stop,
        |generation, best| {
            bar.set_position(generation.into());
            bar.set_message(format!("fitness {best:.0}"));
        },
    )?;
    bar.finish_and_clear();
    file.write(&args.out)?;
    let evolved = Evolved {
        table: &args.out,
        seed: args.seed,
        generations: file.generations,
        fitness: file.fitness(),
        points: file.points,
        grasps_simulated: simulated,
        hash: &file.hash,
        wall_s: start.elapsed().as_secs_f64(),
    };
    answer(format, &evolved, || {
        let mut text = format!(
            "{}: fitness {:.1} of 800; {} generations, {simulated} grasps simulated, in {:.1} s\n",
            args.out.display(),
            evolved.fitness,
            evolved.generations,
            evolved.wall_s
        );
        for (family, points) in families.iter().zip(evolved.points) {
            let _ = writeln!(text, "  {:<18} {points:>5.1}", family.name);
        }
        text
    })
}

/// Executes one run. Returns its table file and the number of simulated grasps.
pub(super) fn run(
    families: &[Family],
    args: &EvolutionArgs,
    seed: u64,
    stop: &AtomicBool,
    mut progress: impl FnMut(u32, f32),
) -> Result<(GraspFile, u64)> {
    let mut evaluator = Evaluator::new(families, Engine::fastest(), args.with_module_3);
    let watch = |generation, best| {
        progress(generation, best);
        continue_unless_set(stop)
    };
    let evolved = evolve_one(
        &mut evaluator,
        Settings::default(),
        seed,
        args.generations,
        watch,
    )?;
    let table = course::table(&evolved.best.genome);
    let origin = (seed, args.generations);
    let file = GraspFile::new(&table, origin, args.with_module_3, evolved.best.points);
    Ok((file, evolved.simulated))
}
