//! `ebts analyse`, `ebts compare`, `ebts export` and `ebts find`: evaluation of experiments.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use clap::Args;
use rayon::prelude::*;
use serde::Serialize;

use ebts::analysis::{
    Case, Comparison, Findings, TrialFacts, comparisons, examples, facts, findings, trace,
};
use ebts::condition::Condition;
use ebts::error::{Error, Result};
use ebts::experiment::{Plan, read_folder};
use ebts::files::write_atomically;
use ebts::genome::Genome;
use ebts::plot::{Panel, trajectories};
use ebts::results::{Summary, write_trials};
use ebts::run::Record;
use ebts::workers::pool;

use super::options::{EngineArgs, csv_file, svg_file};
use super::report;
use super::{Format, answer};

#[derive(Debug, Args)]
#[command(after_help = "Example:\n  ebts analyse fig14 --random-tables 200")]
pub(crate) struct AnalyseArgs {
    /// Folder of an experiment.
    folder: PathBuf,
    #[command(flatten)]
    engine: EngineArgs,
    /// Random tables per team size for comparison.
    #[arg(long, default_value_t = 1000)]
    random_tables: usize,
}

#[derive(Serialize)]
struct Analysis {
    findings: Findings,
    comparisons: Vec<Comparison>,
}

pub(super) fn analyse(args: AnalyseArgs, format: Format) -> Result<()> {
    let engine = args.engine.engine()?;
    let (analysis, runs) = pool(args.engine.threads())?.install(|| {
        let (plan, records) = read_folder(&args.folder)?;
        let analysis = Analysis {
            findings: findings(&plan, &records)?,
            comparisons: comparisons(&plan, &records, engine, args.random_tables)?,
        };
        Ok::<_, Error>((analysis, records.len()))
    })?;
    answer(format, &analysis, || {
        let Findings {
            preset,
            fitness_rule,
            ..
        } = &analysis.findings;
        let header = format!("preset {preset}, fitness rule {fitness_rule}, {runs} runs\n");
        header + &report::findings(&analysis.findings) + &report::comparisons(&analysis.comparisons)
    })
}

#[derive(Debug, Args)]
#[command(after_help = "Example:\n  ebts compare fig14-R3 fig14-R3-literal fig14-R3-compared")]
pub(crate) struct CompareArgs {
    /// Folders of experiments.
    #[arg(required = true)]
    folders: Vec<PathBuf>,
}

#[derive(Serialize)]
struct Compared {
    #[serde(flatten)]
    summary: Summary,
    findings: Findings,
}

pub(super) fn compare(args: CompareArgs, format: Format) -> Result<()> {
    let of = |folder: &PathBuf| {
        let (plan, records) = read_folder(folder)?;
        let findings = findings(&plan, &records)?;
        Ok((Summary::new(&plan, &records, &findings, 0.0, 0.0), findings))
    };
    let compared = args.folders.iter().map(of).collect::<Result<Vec<_>>>()?;
    let text = report::side_by_side(&compared);
    let values: Vec<Compared> = compared
        .into_iter()
        .map(|(summary, findings)| Compared { summary, findings })
        .collect();
    answer(format, &values, || text)
}

#[derive(Debug, Args)]
#[command(after_help = "Example:\n  ebts export fig14 --out trials.csv")]
pub(crate) struct ExportArgs {
    /// Folder of an experiment.
    folder: PathBuf,
    /// CSV file to write, one row per trial [default: trials.csv in the folder].
    ///
    /// Columns: points, delivery, and per agent the frames of pushing and whether it circles, is
    /// trapped or keeps out.
    #[arg(long, value_name = "FILE.csv", value_parser = csv_file)]
    out: Option<PathBuf>,
}

#[derive(Serialize)]
struct Exported {
    file: PathBuf,
    trials: usize,
}

pub(super) fn export(args: ExportArgs, format: Format) -> Result<()> {
    let (plan, records) = read_folder(&args.folder)?;
    let file = args.out.unwrap_or_else(|| args.folder.join("trials.csv"));
    let trials = write_trials(&file, &plan, &records)?;
    let exported = Exported { file, trials };
    answer(format, &exported, || {
        format!("{trials} trials: {}", exported.file.display())
    })
}

#[derive(Debug, Args)]
#[command(after_help = "Example:\n  ebts find fig14 --most 3")]
pub(crate) struct FindArgs {
    /// Folder of an experiment with four agents.
    folder: PathBuf,
    /// Number of listed examples of each case.
    #[arg(long, default_value_t = 5)]
    most: usize,
    /// Figure with the clearest example of each case [default: fig17.svg in the folder].
    #[arg(long, value_name = "FILE.svg", value_parser = svg_file)]
    out: Option<PathBuf>,
}

#[derive(Serialize)]
struct Found {
    case: String,
    trials: usize,
    examples: Vec<TrialFacts>,
}

pub(super) fn find(args: FindArgs, format: Format) -> Result<()> {
    let (plan, records) = read_folder(&args.folder)?;
    let conditions = plan.conditions()?;
    let Some(condition) = conditions
        .iter()
        .find(|condition| condition.team.get() == 4)
    else {
        return Err(Error::refused(
            format_args!("find Fig. 17 in {}", args.folder.display()),
            format_args!("its agents is {:?}", plan.agents),
            "runs of four agents",
            "run the experiment with --agents 4",
        ));
    };
    let four = records.par_iter().filter(|record| record.agents == 4);
    let trials: Vec<TrialFacts> = four
        .flat_map_iter(|record| facts(condition, record))
        .collect();
    let all = Case::ALL.map(|case| (case, examples(case, &trials)));
    let figure = args.out.unwrap_or_else(|| args.folder.join("fig17.svg"));
    let panels: Vec<Panel> = all
        .iter()
        .filter_map(|(case, found)| panel(condition, &records, *case, found.first()?))
        .collect();
    if !panels.is_empty() {
        write_atomically(&figure, trajectories(condition, &panels)?.as_bytes())?;
    }
    let found = all.map(|(case, examples)| Found {
        case: case.to_string(),
        trials: examples.len(),
        examples: examples.into_iter().take(args.most).collect(),
    });
    answer(format, &found, || {
        describe(&plan, &found, (!panels.is_empty()).then_some(&figure))
    })
}

fn panel(
    condition: &Condition,
    records: &[Record],
    case: Case,
    example: &TrialFacts,
) -> Option<Panel> {
    let record = records
        .iter()
        .find(|record| (record.agents, record.seed) == (example.agents, example.seed))?;
    let genome = Genome::from_hex(condition.genome_bits(), &record.genome)?;
    let layout = condition.layouts()[example.goal - 1];
    Some(Panel {
        title: format!(
            "case {}: seed {}, goal {}",
            case.number(),
            example.seed,
            example.goal
        ),
        trace: trace(condition, condition.responses(&genome), &layout),
    })
}

fn describe(plan: &Plan, found: &[Found], figure: Option<&PathBuf>) -> String {
    let mut text = format!(
        "preset {}, fitness rule {}: four agents deliver the object\n",
        plan.preset.name, plan.fitness_rule
    );
    for Found {
        case,
        trials,
        examples,
    } in found
    {
        let _ = writeln!(text, "\n{case}: {trials} trials");
        if !examples.is_empty() {
            text += "  seed  goal  at goal from frame  pushes in frames (agents 1 to 4)\n";
        }
        for trial in examples {
            let frames = trial
                .each()
                .iter()
                .map(|agent| agent.pushing_frames.to_string());
            let _ = writeln!(
                text,
                "{:>6}  {:>4}  {:>18}  {}",
                trial.seed,
                trial.goal,
                trial.reached_frame,
                frames.collect::<Vec<_>>().join(", ")
            );
        }
    }
    if let Some(figure) = figure.map(PathBuf::as_path).map(Path::display) {
        let _ = writeln!(text, "\nfigure: {figure}");
    }
    text
}
