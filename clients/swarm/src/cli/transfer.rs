//! `ebts transfer`: fitness of tables on unseen starts and goals.

use std::path::PathBuf;

use clap::Args;
use serde::Serialize;

use ebts::analysis::{Transfer, UNSEEN_SETS, transfer, transfers};
use ebts::error::Result;
use ebts::experiment::read_folder;
use ebts::scoring::Scoring;
use ebts::table_file::TableFile;
use ebts::workers::pool;
use field::{Places, Preset};

use super::options::EngineArgs;
use super::report;
use super::{Format, answer};

const EXAMPLES: &str = "Examples:
  printf 'base = \"R3\"\\ntraining = { draws = 8 }\\n' > drawn.toml
  ebts experiment fig14 --preset drawn.toml --agents 3 --seeds 20 --out drawn
  ebts transfer drawn
  ebts transfer drawn/best-3.toml

Unseen starts and goals come from a separate random stream, equal for every
table.";

#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct TransferArgs {
    /// Folder of an experiment, or a table file.
    what: PathBuf,
    #[command(flatten)]
    engine: EngineArgs,
}

#[derive(Serialize)]
struct Transferred {
    preset: String,
    fitness_rule: Scoring,
    /// Settings for drawn trials during evolution; null if none were drawn.
    training: Option<field::Training>,
    /// Sets of eight unseen trials of each kind.
    unseen_sets: usize,
    teams: Vec<Transfer>,
}

impl Transferred {
    fn new(preset: &Preset, fitness_rule: Scoring, teams: Vec<Transfer>) -> Self {
        Self {
            preset: preset.name.to_string(),
            fitness_rule,
            training: preset.training,
            unseen_sets: UNSEEN_SETS,
            teams,
        }
    }
}

pub(super) fn run(args: TransferArgs, format: Format) -> Result<()> {
    let transferred = pool(args.engine.threads())?.install(|| measure(&args))?;
    answer(format, &transferred, || describe(&transferred))
}

fn measure(args: &TransferArgs) -> Result<Transferred> {
    let engine = args.engine.engine()?;
    if args.what.is_dir() {
        let (plan, records) = read_folder(&args.what)?;
        let teams = transfers(&plan, engine, &records)?;
        return Ok(Transferred::new(
            &plan.preset,
            plan.fitness_rule.into(),
            teams,
        ));
    }
    let file = TableFile::read(&args.what)?;
    let condition = &file.condition;
    let cure = "evaluate it with the program that evolved it";
    condition.fitness.check_available(&args.what, cure)?;
    let teams = vec![transfer(&file, engine)];
    Ok(Transferred::new(
        condition.model.preset(),
        condition.fitness.clone(),
        teams,
    ))
}

fn describe(transferred: &Transferred) -> String {
    let message = |places: Places| match places {
        Places::Preset => "the preset's",
        Places::Drawn => "drawn",
    };
    let evolved_on = transferred.training.map_or_else(
        || "the preset's starts and eight goals".to_owned(),
        |training| {
            let (starts, goals) = (message(training.starts), message(training.goals));
            format!(
                "starts {starts}, goals {goals}, {} x 8 trials",
                training.draws
            )
        },
    );
    format!(
        "preset {}, fitness rule {}\nevolved on: {evolved_on}\n{}",
        transferred.preset,
        transferred.fitness_rule,
        report::transfers(&transferred.teams)
    )
}
