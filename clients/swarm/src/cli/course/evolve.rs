//! `ebts evolve course`: one run.

use std::path::{Path, PathBuf};
use std::time::Instant;

use clap::Args;
use indicatif::ProgressBar;
use serde::Serialize;

use ebts::course::evolve::evolve as evolve_one;
use ebts::course::fitness::held_out;
use ebts::course::table_file::CourseFile;
use ebts::error::Result;
use ebts::evaluate::GoalPoints;
use ebts::ga::Settings;
use field::Responses;

use super::{Format, answer, check_overwrite, continue_unless_set, stop_flag, style, toml_file};

/// Held-out courses for the evaluation of an evolved table.
pub(super) const HELD_OUT: u64 = 100;

#[derive(Debug, Args)]
#[command(
    after_help = "Example:\n  ebts evolve course --seed 1 --out mine-course.toml\n  atas eval hybrid --table mine-course.toml"
)]
pub(crate) struct EvolveCourseArgs {
    /// Generations after the random population.
    ///
    /// With many more, tables adapt to the courses instead of the task.
    #[arg(long, default_value_t = 60)]
    generations: u32,
    /// Seed of the run: the same seed gives the same table, bit for bit.
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u64).range(..=i64::MAX as u64))]
    seed: u64,
    /// Table file to write.
    #[arg(long, value_name = "FILE.toml", default_value = "course.toml", value_parser = toml_file)]
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
    /// Share of unseen courses completed with one robot and with two.
    held_out: [f64; 2],
    groups_driven: u64,
    hash: &'a str,
    wall_s: f64,
}

pub(in crate::cli) fn evolve(args: &EvolveCourseArgs, format: Format) -> Result<()> {
    let start = Instant::now();
    check_overwrite(&args.out, args.overwrite)?;
    let stop = stop_flag()?;
    let bar = ProgressBar::new(args.generations.into()).with_style(style("generation"));
    let watch = |generation: u32, best: f32| {
        bar.set_position(generation.into());
        bar.set_message(format!("fitness {best:.0}"));
        continue_unless_set(&stop)
    };
    let evolved = evolve_one(Settings::default(), args.seed, args.generations, watch)?;
    bar.finish_and_clear();
    let table = Responses::from_motor_bits(evolved.best.genome.words()[0]);
    let origin = (args.seed, args.generations);
    let file = CourseFile::new(table, origin, evolved.best.points);
    file.write(&args.out)?;
    let reported = Evolved {
        table: &args.out,
        seed: args.seed,
        generations: args.generations,
        fitness: file.fitness(),
        points: file.points,
        held_out: [held_out(table, 1, HELD_OUT)?, held_out(table, 2, HELD_OUT)?],
        groups_driven: evolved.simulated_groups,
        hash: &file.hash,
        wall_s: start.elapsed().as_secs_f64(),
    };
    answer(format, &reported, || {
        let [one, two] = reported.held_out.map(|share| share * 100.0);
        format!(
            "{}: fitness {:.1} of 800 after {} generations, in {:.1} s\n\
             of {HELD_OUT} unseen courses with hands as time delays: {one:.0} % with one robot, {two:.0} % with two\n\
             hash {}\n",
            args.out.display(),
            reported.fitness,
            reported.generations,
            reported.wall_s,
            reported.hash,
        )
    })
}
