//! Converts a stored condition ([`Setup`]) to a validated [`Condition`]: its field, and whether its
//! training trials can be drawn there.

use std::sync::Arc;

use field::{Model, TeamSize};

use crate::condition::{Condition, Setup};
use crate::error::{Error, Result};
use crate::training;

impl Setup {
    /// Validates all values.
    pub fn build(self) -> Result<Condition> {
        let condition = Condition {
            team: TeamSize::new(self.agents).map_err(Error::from_part)?,
            model: Arc::new(Model::new(self.preset).map_err(Error::from_part)?),
            sharing: self.sharing,
            sensors: self.sensors,
            fitness: self.fitness_rule,
        };
        training::check(&condition).map(|()| condition)
    }
}
