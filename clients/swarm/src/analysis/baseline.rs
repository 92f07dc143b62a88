//! Baselines: tables without evolution, as a lower bound for evolved ones.

use serde::Serialize;

use field::Engine;

use super::points_in;
use crate::condition::Condition;
use crate::genome::Genome;
use crate::rng::SplitMix64;
use crate::sensors::SensorOrder;
use crate::stats::{mean, quantile, sorted};
use crate::table::{Shape, Table};

const RANDOM_STREAM: u64 = 0x7261_6e64;

/// Fitness (of 800) of tables without evolution, for one condition.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Baselines {
    /// Fitness of [`hand_written`].
    pub hand_written: f32,
    /// Number of random tables.
    pub random_tables: usize,
    /// Mean fitness of the random tables.
    pub random_mean: f32,
    /// Best fitness of the random tables: a random search with this many evaluations.
    pub random_best: f32,
}

/// Returns a hand-written table: drives into the light, turns towards the side with light, avoids
/// walls in the dark. Columns in the default sensor order.
#[must_use]
pub fn hand_written() -> Table {
    Table::from_levels(Shape::MOBILE_ROBOT, |row, motor| {
        let sees = |column: usize| row >> column & 1 == 1;
        let (front, right) = (sees(1), sees(2));
        let (left_wheel, right_wheel) = match (sees(3), sees(4)) {
            (true, true) => (2, 2),
            (true, false) => (1, 2),
            (false, true) => (2, 1),
            (false, false) if front || right => (0, 2),
            (false, false) if sees(0) => (2, 0),
            (false, false) => (2, 2),
        };
        [left_wheel, right_wheel][motor]
    })
}

/// Evaluates the hand-written table and random ones.
#[must_use]
pub fn baselines(condition: &Condition, engine: Engine, random_tables: usize) -> Baselines {
    let layouts = condition.layouts();
    let fitness =
        |genome: &Genome| points_in(condition, engine, condition.responses(genome), &layouts);
    let mut rng = SplitMix64::stream(&[RANDOM_STREAM]);
    let random: Vec<f32> = (0..random_tables)
        .map(|_| fitness(&Genome::random(condition.genome_bits(), &mut rng)))
        .collect();
    let hand = SensorOrder::default().responses(hand_written().genome().words()[0]);
    Baselines {
        hand_written: points_in(condition, engine, [hand; field::MAX_AGENTS], &layouts),
        random_tables,
        random_mean: mean(&random),
        random_best: quantile(&sorted(&random), 1.0),
    }
}
