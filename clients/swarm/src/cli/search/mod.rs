//! `ebts search`: searches for a preset on which chosen findings of the paper hold.

mod text;

use std::path::{Path, PathBuf};

use clap::Args;
use indicatif::ProgressBar;
use serde::Serialize;

use ebts::analysis::{Claim, findings};
use ebts::error::{Error, Result};
use ebts::experiment::{Plan, Shard};
use ebts::files::write_atomically;
use ebts::run::Record;
use ebts::search::{
    Candidate, CoOccurrence, Halving, Range, Score, Stage, candidates, co_occurrences,
};
use ebts::workers::{Workers, pool};
use field::Preset;

use super::experiment::{Stopwatch, conclude, run};
use super::options::{EngineArgs, EvolutionArgs};
use super::progress::style;
use super::{Format, answer, preset, stop_flag};

const EXAMPLES: &str = "Examples:
  ebts search --preset LB3 --vary goal_radius_px=30.0..60.0 \\
       --vary friction_per_stall_force=0.9..1.0 --candidates 60 --out search
  ebts search --preset N3 --vary ir_angle_steps=6..14 \\
       --vary contact=sliding,blocking --find three-beat-two,circles

Findings: five-times, five-times-run-by-run, three-beat-four, two-beat-four,
three-beat-two, trapped, circles, keep-out.

The same command continues after Ctrl-C or a power cut. Every candidate is an
experiment in the folder, for ebts analyse, compare and find.";

#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct SearchArgs {
    /// A key of the preset and a numeric range or values; repeat for several keys.
    #[arg(long, required = true, value_name = "KEY=LOW..HIGH|KEY=V,...")]
    vary: Vec<Range>,
    /// Findings that must hold together.
    #[arg(
        long,
        value_delimiter = ',',
        default_value = "five-times,three-beat-four,three-beat-two,circles,keep-out",
        value_name = "FINDING,..."
    )]
    find: Vec<Claim>,
    #[command(flatten)]
    evolution: EvolutionArgs,
    #[command(flatten)]
    engine: EngineArgs,
    /// Presets of the first stage.
    ///
    /// Each further stage has a third of them on twice as many further seeds.
    #[arg(long, default_value_t = 60)]
    candidates: usize,
    /// Presets that receive a verdict.
    #[arg(long, default_value_t = 3)]
    best: usize,
    /// Seed for the draw of the presets.
    #[arg(long, default_value_t = 1)]
    draw: u64,
    /// Runs per team size in the first stage.
    #[arg(long, default_value_t = 8, value_parser = clap::value_parser!(u64).range(1..=10_000))]
    seeds: u64,
    /// First seed used for choosing; the others follow it.
    #[arg(long, default_value_t = 1_000_001, value_parser = clap::value_parser!(u64).range(..=i64::MAX as u64 / 2))]
    first_seed: u64,
    /// Runs per team size for the verdict.
    #[arg(long, default_value_t = 80, value_parser = clap::value_parser!(u64).range(1..=1_000_000))]
    verdict_seeds: u64,
    /// First seed of the verdict; these seeds choose nothing.
    #[arg(long, default_value_t = 9_000_001, value_parser = clap::value_parser!(u64).range(..=i64::MAX as u64 / 2))]
    verdict_first_seed: u64,
    /// Folder of the search; an existing one is continued.
    #[arg(long, default_value = "search")]
    out: PathBuf,
}

#[derive(Serialize)]
struct Searched {
    preset: String,
    find: Vec<Claim>,
    stages: Vec<Stage>,
    verdict_first_seed: u64,
    verdict_seeds: u64,
    /// Presets by their verdict, the most probable first.
    best: Vec<Found>,
    /// Co-occurrence over the candidates of the first stage.
    together: Vec<CoOccurrence>,
}

#[derive(Serialize)]
struct Found {
    file: PathBuf,
    folder: PathBuf,
    changes: String,
    preset: Preset,
    /// Score on the tuning seeds, which is optimistic because of the selection.
    tuning: Score,
    verdict: Score,
    all_hold: bool,
}

struct ScoredCandidate {
    candidate: Candidate,
    records: Vec<Record>,
    score: Score,
}

struct Search<'a> {
    args: &'a SearchArgs,
    halving: Halving,
    workers: Workers,
}

pub(super) fn search(args: SearchArgs, format: Format) -> Result<()> {
    let halving = Halving {
        candidates: args.candidates,
        best: args.best,
        seeds: args.seeds,
        first_seed: args.first_seed,
        verdict_seeds: args.verdict_seeds,
        verdict_first_seed: args.verdict_first_seed,
    };
    halving.check()?;
    let base = args.evolution.preset()?;
    let candidates = candidates(&base, &args.vary, args.candidates, args.draw)?;
    let search = Search {
        args: &args,
        halving,
        workers: args.engine.workers(stop_flag()?)?,
    };
    let (tried, together) = search.tune(candidates)?;
    let mut best = tried
        .into_iter()
        .map(|tried| search.run_verdict(tried))
        .collect::<Result<Vec<_>>>()?;
    best.sort_by(|a, b| b.verdict.chance_of_all.total_cmp(&a.verdict.chance_of_all));
    let searched = Searched {
        preset: base.name.to_string(),
        find: args.find.clone(),
        stages: halving.stages(),
        verdict_first_seed: args.verdict_first_seed,
        verdict_seeds: args.verdict_seeds,
        best,
        together,
    };
    answer(format, &searched, || text::describe(&searched))
}

impl Search<'_> {
    /// Runs all stages. Returns the best candidates of the last and the co-occurrence of findings
    /// in the first.
    fn tune(
        &self,
        candidates: Vec<Candidate>,
    ) -> Result<(Vec<ScoredCandidate>, Vec<CoOccurrence>)> {
        let mut tried: Vec<ScoredCandidate> = candidates
            .into_iter()
            .map(|candidate| ScoredCandidate {
                candidate,
                records: Vec::new(),
                score: Score {
                    claims: Vec::new(),
                    chance_of_all: 0.0,
                },
            })
            .collect();
        let mut pairs = None;
        for stage in self.halving.stages() {
            tried.truncate(stage.candidates);
            self.run_stage(&stage, &mut tried)?;
            pairs.get_or_insert_with(|| {
                co_occurrences(&tried.iter().map(|tried| &tried.score).collect::<Vec<_>>())
            });
            tried.sort_by(|a, b| b.score.chance_of_all.total_cmp(&a.score.chance_of_all));
        }
        tried.truncate(self.halving.best);
        Ok((tried, pairs.unwrap_or_default()))
    }

    fn run_stage(&self, stage: &Stage, tried: &mut [ScoredCandidate]) -> Result<()> {
        let bar = ProgressBar::new(tried.len() as u64).with_style(style("preset"));
        let mut best = 0.0_f64;
        for tried in tried {
            bar.set_message(format!(
                "stage {}, best chance of all {:.0} %",
                stage.number,
                100.0 * best
            ));
            let folder = self.folder(&format!("stage-{}", stage.number), &tried.candidate);
            let seeds = (stage.first_seed, stage.seeds);
            let plan = self.plan(&tried.candidate, seeds)?;
            tried.records.extend(self.run(&plan, &folder)?);
            tried.score = self.score(&plan, &tried.records)?;
            best = best.max(tried.score.chance_of_all);
            bar.inc(1);
        }
        bar.finish_and_clear();
        Ok(())
    }

    /// Runs the verdict of one candidate as a complete experiment.
    fn run_verdict(&self, tried: ScoredCandidate) -> Result<Found> {
        let ScoredCandidate {
            candidate, score, ..
        } = tried;
        let watch = Stopwatch::start();
        let folder = self.folder("verdict", &candidate);
        let seeds = (self.args.verdict_first_seed, self.args.verdict_seeds);
        let plan = self.plan(&candidate, seeds)?;
        let records = self.run(&plan, &folder)?;
        let (_, found) = pool(self.args.engine.threads())?
            .install(|| conclude(&folder, &plan, &records, &watch))?;
        let verdict = Score::new(&found, &self.args.find);
        let file = self.args.out.join(format!("{}.toml", candidate.label()));
        write_atomically(&file, preset::file(&candidate.preset)?.as_bytes())?;
        Ok(Found {
            file,
            folder,
            changes: candidate.changes,
            preset: candidate.preset,
            tuning: score,
            all_hold: verdict.all_hold(),
            verdict,
        })
    }

    fn plan(&self, candidate: &Candidate, (first_seed, seeds): (u64, u64)) -> Result<Plan> {
        let preset = candidate.preset.clone();
        let plan = Plan {
            first_seed,
            ..self.args.evolution.plan(preset, seeds)?
        };
        plan.conditions().map(|_| plan)
    }

    fn run(&self, plan: &Plan, folder: &Path) -> Result<Vec<Record>> {
        let threads = self.args.engine.threads();
        let hidden = ProgressBar::hidden();
        let workers = (&self.workers, threads);
        match run(plan, Shard::WHOLE, folder, workers, &hidden) {
            Err(Error::Interrupted(_)) => Err(Error::Interrupted(format!(
                "interrupted at {}: finished runs are stored, runs in progress are saved; run the \
                 same command again to continue",
                folder.display()
            ))),
            ended => ended.map(|(records, _)| records),
        }
    }

    fn score(&self, plan: &Plan, records: &[Record]) -> Result<Score> {
        let found = pool(self.args.engine.threads())?.install(|| findings(plan, records))?;
        Ok(Score::new(&found, &self.args.find))
    }

    fn folder(&self, part: &str, candidate: &Candidate) -> PathBuf {
        self.args.out.join(part).join(candidate.label())
    }
}
