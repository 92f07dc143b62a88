//! Evolution of one population, used for the tables of a hand and the tables of a base.

use std::ops::ControlFlow;

use crate::error::{Error, Result};
use crate::evaluate::Individual;
use crate::ga::{Population, Settings};
use crate::genome::Genome;
use crate::rng::SplitMix64;
use crate::run::Rise;

/// Evolves genomes of a number of bits. `watch` receives every generation and its best fitness and
/// may stop the run; the error then includes `saved_text`. Returns the best individual and the
/// generations in which the best fitness rose.
///
/// # Errors
/// The settings are invalid, or the run was stopped.
pub(crate) fn evolve(
    settings: Settings,
    (bits, rng): (usize, SplitMix64),
    generations: u32,
    saved_text: &str,
    mut evaluate: impl FnMut(Vec<Genome>) -> Vec<Individual>,
    mut watch: impl FnMut(u32, f32) -> ControlFlow<()>,
) -> Result<(Individual, Vec<Rise>)> {
    let mut population = Population::new(settings, bits, rng).map_err(Error::from_part)?;
    let mut rises: Vec<Rise> = Vec::new();
    for generation in 0..=generations {
        let children = evaluate(population.propose());
        population.select(children);
        let best = population.members()[0].fitness();
        Rise::record(&mut rises, generation, best);
        if watch(generation, best).is_break() {
            let sentence = format!("interrupted at generation {generation}; {saved_text}");
            return Err(Error::Interrupted(sentence));
        }
    }
    Ok((population.members()[0].clone(), rises))
}
