//! Output files of an experiment. Deterministic; long files are written row by row.

use std::path::Path;

use super::summary::write_json;
use crate::analysis::{Findings, TrialFacts, facts};
use crate::error::Result;
use crate::experiment::Plan;
use crate::files::stream_atomically;
use crate::run::Record;
use crate::table_file::TableFile;

/// Generations between two rows of `curves.csv`. The first [`CURVE_START`] generations, which
/// change most, are complete.
const CURVE_STEP: u32 = 10;
const CURVE_START: u32 = 50;

/// Writes `findings.json`, `runs.csv`, `curves.csv` and the best table of every team size.
pub fn write_results(
    folder: &Path,
    plan: &Plan,
    records: &[Record],
    findings: &Findings,
) -> Result<()> {
    write_json(&folder.join("findings.json"), findings)?;
    write_runs(&folder.join("runs.csv"), plan, records)?;
    write_curves(&folder.join("curves.csv"), plan, records)?;
    for condition in plan.conditions()? {
        let agents = condition.team.get();
        let runs = records.iter().filter(|record| record.agents == agents);
        let better = |best: &'_ Record, other: &'_ Record| other.fitness() > best.fitness();
        let best = runs.reduce(|best, other| if better(best, other) { other } else { best });
        if let Some(best) = best {
            TableFile::from_record(&condition, best, plan.generations)?
                .write(&folder.join(format!("best-{agents}.toml")))?;
        }
    }
    Ok(())
}

fn write_runs(path: &Path, plan: &Plan, records: &[Record]) -> Result<()> {
    stream_atomically(path, |file| {
        let mut rows = csv::Writer::from_writer(file);
        rows.write_record([
            "agents",
            "seed",
            "fitness_rule",
            "fitness",
            "full_scores",
            "last_rise",
            "genome",
        ])?;
        for record in records {
            let last_rise = record.rises.last().map_or(0, |rise| rise.generation);
            rows.write_record([
                record.agents.to_string(),
                record.seed.to_string(),
                plan.fitness_rule.to_string(),
                record.fitness().to_string(),
                record.full_scores().to_string(),
                last_rise.to_string(),
                record.genome.clone(),
            ])?;
        }
        rows.flush()
    })
}

fn write_curves(path: &Path, plan: &Plan, records: &[Record]) -> Result<()> {
    let shown = |generation: &u32| {
        let steps = generation.is_multiple_of(CURVE_STEP);
        *generation < CURVE_START || steps || *generation == plan.generations
    };
    stream_atomically(path, |file| {
        let mut rows = csv::Writer::from_writer(file);
        rows.write_record(["agents", "seed", "generation", "max_fitness"])?;
        for record in records {
            for generation in (0..=plan.generations).filter(shown) {
                rows.write_record([
                    record.agents.to_string(),
                    record.seed.to_string(),
                    generation.to_string(),
                    record.fitness_at(generation).to_string(),
                ])?;
            }
        }
        rows.flush()
    })
}

/// Writes one row per trial with its result and the behaviour of every agent. Returns the number of
/// rows.
pub fn write_trials(path: &Path, plan: &Plan, records: &[Record]) -> Result<usize> {
    let conditions = plan.conditions()?;
    let mut count = 0;
    stream_atomically(path, |file| {
        let mut rows = csv::Writer::from_writer(file);
        rows.write_record(trial_columns())?;
        for record in records {
            let team =
                |condition: &&crate::condition::Condition| condition.team.get() == record.agents;
            for trial in conditions
                .iter()
                .find(team)
                .map_or(Vec::new(), |c| facts(c, record))
            {
                rows.write_record(trial_row(&trial))?;
                count += 1;
            }
        }
        rows.flush()
    })?;
    Ok(count)
}

fn trial_columns() -> Vec<String> {
    let mut columns = [
        "agents",
        "seed",
        "goal",
        "points",
        "delivered",
        "reached_frame",
        "distance_px",
        "pushers",
    ]
    .map(str::to_owned)
    .to_vec();
    for agent in 1..=field::MAX_AGENTS {
        columns.extend(
            ["pushing_frames", "circles", "trapped", "keeps_out"]
                .map(|what| format!("{what}_{agent}")),
        );
    }
    columns
}

/// Formats a trial; columns of absent agents are empty. An agent keeps out of a trial that the
/// others solve without it.
fn trial_row(trial: &TrialFacts) -> Vec<String> {
    let mut row = vec![
        trial.agents.to_string(),
        trial.seed.to_string(),
        trial.goal.to_string(),
        trial.points.to_string(),
        trial.delivered.to_string(),
        trial.reached_frame.to_string(),
        trial.distance_px.to_string(),
        trial.pushers().to_string(),
    ];
    for agent in trial.each() {
        row.extend([
            agent.pushing_frames.to_string(),
            agent.circling.to_string(),
            agent.trapped.to_string(),
            (trial.delivered && !agent.pushes()).to_string(),
        ]);
    }
    row.resize(trial_columns().len(), String::new());
    row
}
