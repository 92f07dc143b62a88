//! The condition of a run: which field, how many agents, how they share tables, how they are scored.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use field::{Layout, MAX_AGENTS, Model, Point, Preset, Responses, TeamSize, Training};

use crate::genome::Genome;
use crate::scoring::{Fitness, Judged, Scoring};
use crate::sensors::SensorOrder;
use crate::table::{Shape, Table};

/// Goals of one evaluation (paper III.b.3).
pub const GOALS: usize = 8;

/// Whether the agents of a team share a table.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Sharing {
    /// One table for all (the paper).
    Shared,
    /// One table per agent, side by side in the genome.
    PerAgent,
}

/// Everything that a fitness depends on besides the genome.
#[derive(Clone, Debug)]
pub struct Condition {
    /// The field.
    pub model: Arc<Model>,
    /// How many agents.
    pub team: TeamSize,
    /// How they share tables.
    pub sharing: Sharing,
    /// What S1–S5 are.
    pub sensors: SensorOrder,
    /// How trials are scored.
    pub fitness: Scoring,
}

/// A condition as files keep it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Setup {
    /// How many agents.
    pub agents: usize,
    /// How they share tables.
    pub sharing: Sharing,
    /// What S1–S5 are.
    pub sensors: SensorOrder,
    /// How trials are scored.
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
    /// The paper's condition: a shared table, the default sensor order.
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

    /// The same, judged by a rule of one's own.
    #[must_use]
    pub fn judged_by(self, fitness: impl Fitness + 'static) -> Self {
        Self {
            fitness: Scoring::Own(Arc::new(fitness)),
            ..self
        }
    }

    /// What is drawn for every generation; `None` if every generation has the preset's eight trials.
    #[must_use]
    pub fn training(&self) -> Option<Training> {
        self.model.preset().training
    }

    /// Tables in one genome.
    #[must_use]
    pub fn tables(&self) -> usize {
        match self.sharing {
            Sharing::Shared => 1,
            Sharing::PerAgent => self.team.get(),
        }
    }

    /// Bits of one genome.
    #[must_use]
    pub fn genome_bits(&self) -> usize {
        self.tables() * Shape::MOBILE_ROBOT.genome_bits()
    }

    /// The tables that a genome describes.
    #[must_use]
    pub fn tables_of(&self, genome: &Genome) -> Vec<Table> {
        let shape = Shape::MOBILE_ROBOT;
        (0..self.tables())
            .map(|t| Table::from_genome(shape, genome, t * shape.genome_bits()))
            .collect()
    }

    /// The responses of each of the field's agents.
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

    /// The preset's own eight layouts, goal 1 first: what tables are evolved on, unless trials are drawn (see
    /// [`crate::training`]), and what is drawn and replayed of them.
    #[must_use]
    pub fn layouts(&self) -> [Layout; GOALS] {
        self.model
            .training_goals()
            .map(|goal: Point| self.model.training_layout(goal))
    }

    /// The points of one outcome.
    #[must_use]
    pub fn points(&self, outcome: &field::Outcome) -> f32 {
        self.fitness.points(&Judged {
            preset: self.model.preset(),
            team: self.team,
            outcome,
        })
    }
}
