//! Evolution with a custom fitness: `cargo run -p ebts --example own_fitness -- quick.toml`.

use std::ops::ControlFlow;
use std::path::Path;
use std::sync::Arc;

use ebts::condition::Condition;
use ebts::error::{Error, Result};
use ebts::ga::Settings;
use ebts::islands::IslandSettings;
use ebts::run::{Run, evolve};
use ebts::scoring::{Fitness, TrialResult};
use ebts::table_file::TableFile;
use field::{Engine, FitnessRule, Model, Preset, TRIAL_FRAMES, TeamSize};

/// Rewards early delivery; an undelivered object earns up to 10 points for its distance to the
/// goal.
#[derive(Debug)]
pub(crate) struct Quick;

impl Fitness for Quick {
    fn points(&self, trial: &TrialResult<'_>) -> f32 {
        if trial.delivered() {
            let frames_left = TRIAL_FRAMES - trial.outcome.reached_frame;
            return 50.0 + 50.0 * frames_left as f32 / TRIAL_FRAMES as f32;
        }
        trial.accuracy().min(10.0)
    }
}

/// Returns the best table for two agents on R3 after 300 generations; deterministic for a seed.
pub(crate) fn evolved(seed: u64) -> Result<TableFile> {
    const GENERATIONS: u32 = 300;
    let model = Model::new(Preset::R3).map_err(Error::from_part)?;
    let team = TeamSize::new(2).map_err(Error::from_part)?;
    let condition =
        Condition::new(Arc::new(model), team, FitnessRule::AntiAccident).with_fitness(Quick);
    let (settings, islands) = (Settings::default(), IslandSettings::default());
    let mut runs = [Run::new(&condition, settings, islands, seed).map_err(Error::from_part)?];
    let go_on = |_: &[Run]| ControlFlow::Continue(());
    let _ = evolve(&condition, Engine::fastest(), &mut runs, GENERATIONS, go_on);
    let record = runs[0].record(&condition).expect("a finished run");
    TableFile::from_record(&condition, &record, GENERATIONS)
}

#[expect(clippy::print_stdout, reason = "output of the example")]
fn main() -> Result<()> {
    let out = std::env::args().nth(1).unwrap_or("quick.toml".to_owned());
    let file = evolved(1)?;
    file.write(Path::new(&out))?;
    println!(
        "{out}: fitness {:.1} of 800 by the rule {}, table {}",
        file.individual.fitness(),
        file.condition.fitness,
        &file.hash()[..16],
    );
    Ok(())
}
