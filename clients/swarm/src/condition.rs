//! Condition of a run: field, number of agents, table sharing, sensor order, scoring.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use field::{Layout, MAX_AGENTS, Model, Point, Preset, Responses, TeamSize, Training};

use crate::genome::Genome;
use crate::scoring::{Fitness, Scoring, TrialResult};
use crate::sensors::SensorOrder;
use crate::table::{Shape, Table};

/// Goals of one evaluation (paper III.b.3).
pub const GOALS: usize = 8;

/// Assignment of tables to the agents of a team.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Sharing {
    /// One table for all agents (the paper).
    Shared,
    /// One table per agent, concatenated in the genome.
    PerAgent,
}

/// All inputs of a fitness except the genome.
#[derive(Clone, Debug)]
pub struct Condition {
    /// The field.
    pub model: Arc<Model>,
    /// Number of agents.
    pub team: TeamSize,
    /// Assignment of tables to agents.
    pub sharing: Sharing,
    /// Order of the sensors S1–S5.
    pub sensors: SensorOrder,
    /// Scoring of trials.
    pub fitness: Scoring,
}

/// Stored form of a condition.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Setup {
    /// Number of agents.
    pub agents: usize,
    /// Assignment of tables to agents.
    pub sharing: Sharing,
    /// Order of the sensors S1–S5.
    pub sensors: SensorOrder,
    /// Scoring of trials.
    pub fitness_rule: Scoring,
    /// The field.
    pub preset: Preset,
}

impl From<&Condition> for Setup {
    fn from(condition: &Condition) -> Self {
        Self {
            agents: condition.team.get(),
            sharing: condition.sharing,
            sensors: condition.sensors,
            fitness_rule: condition.fitness.clone(),
            preset: condition.model.preset().clone(),
        }
    }
}

impl Condition {
    /// Returns the paper's condition: a shared table, the default sensor order.
    #[must_use]
    pub fn new(model: Arc<Model>, team: TeamSize, fitness: impl Into<Scoring>) -> Self {
        Self {
            model,
            team,
            sharing: Sharing::Shared,
            sensors: SensorOrder::default(),
            fitness: fitness.into(),
        }
    }

    /// Replaces the scoring by a custom fitness.
    #[must_use]
    pub fn with_fitness(self, fitness: impl Fitness + 'static) -> Self {
        Self {
            fitness: Scoring::Custom(Arc::new(fitness)),
            ..self
        }
    }

    /// Returns the settings for drawn trials; `None` if every generation uses the eight trials of
    /// the preset.
    #[must_use]
    pub fn training(&self) -> Option<Training> {
        self.model.preset().training
    }

    /// Returns the number of tables in one genome.
    #[must_use]
    pub fn tables(&self) -> usize {
        match self.sharing {
            Sharing::Shared => 1,
            Sharing::PerAgent => self.team.get(),
        }
    }

    /// Returns the number of bits of one genome.
    #[must_use]
    pub fn genome_bits(&self) -> usize {
        self.tables() * Shape::MOBILE_ROBOT.genome_bits()
    }

    /// Returns the tables that a genome encodes.
    #[must_use]
    pub fn tables_of(&self, genome: &Genome) -> Vec<Table> {
        let shape = Shape::MOBILE_ROBOT;
        (0..self.tables())
            .map(|t| Table::from_genome(shape, genome, t * shape.genome_bits()))
            .collect()
    }

    /// Returns the responses of each agent of the field.
    #[must_use]
    pub fn responses(&self, genome: &Genome) -> [Responses; MAX_AGENTS] {
        let words = genome.words();
        match self.sharing {
            Sharing::Shared => [self.sensors.responses(words[0]); MAX_AGENTS],
            Sharing::PerAgent => std::array::from_fn(|agent| {
                self.sensors
                    .responses(words.get(agent).copied().unwrap_or(0))
            }),
        }
    }

    /// Returns the eight layouts of the preset, goal 1 first. They are used for evolution (unless
    /// trials are drawn, see [`crate::training`]), for plots and for replays.
    #[must_use]
    pub fn layouts(&self) -> [Layout; GOALS] {
        self.model
            .training_goals()
            .map(|goal: Point| self.model.training_layout(goal))
    }

    /// Returns the points of one outcome.
    #[must_use]
    pub fn points(&self, outcome: &field::Outcome) -> f32 {
        self.fitness.points(&TrialResult {
            preset: self.model.preset(),
            team: self.team,
            outcome,
        })
    }
}
