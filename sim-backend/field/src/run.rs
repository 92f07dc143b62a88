//! Trial of the scalar reference, stepped from outside.

use crate::model::{Model, TeamSize};
use crate::responses::Wheels;
use crate::trial::{EXECUTION_FRAMES, Layout, MAX_AGENTS, Outcome, TRIAL_FRAMES, Trial};
use crate::world::World;

/// One trial; the caller alternates [`TrialRun::sense`] and [`TrialRun::advance`].
#[derive(Clone, Debug)]
pub struct TrialRun {
    world: World,
    team: TeamSize,
    frame: u32,
    outcome: Outcome,
}

impl TrialRun {
    /// Creates a trial before its first frame.
    #[must_use]
    pub fn new(model: &Model, team: TeamSize, layout: &Layout) -> Self {
        Self {
            world: World::new(model, team, layout),
            team,
            frame: 0,
            outcome: Outcome::default(),
        }
    }

    /// Returns the table row of every agent and records it.
    pub fn sense(&mut self) -> [u8; MAX_AGENTS] {
        let rows = self.world.sense();
        for row in &rows[..self.team.get()] {
            self.outcome.rows_read |= 1 << row;
        }
        rows
    }

    /// Simulates one frame; a finished trial does not change.
    pub fn advance(&mut self, wheels: &[Wheels; MAX_AGENTS]) {
        if self.is_over() {
            return;
        }
        self.world.advance(wheels);
        self.frame += 1;
        if self.outcome.reached_frame == 0 && self.world.object_at_goal() {
            self.outcome.reached_frame = self.frame;
        }
        match self.frame {
            EXECUTION_FRAMES => self.outcome.executed = self.world.snapshot(),
            TRIAL_FRAMES => self.outcome.evaluated = self.world.snapshot(),
            _ => {}
        }
    }

    /// Returns the number of finished frames.
    #[must_use]
    pub fn frame(&self) -> u32 {
        self.frame
    }

    /// Returns true after the last frame.
    #[must_use]
    pub fn is_over(&self) -> bool {
        self.frame == TRIAL_FRAMES
    }

    /// Returns the outcome, complete when the trial [is over](TrialRun::is_over).
    #[must_use]
    pub fn outcome(&self) -> Outcome {
        self.outcome
    }

    /// Returns the field.
    #[must_use]
    pub fn world(&self) -> &World {
        &self.world
    }
}

/// Simulates one trial.
#[must_use]
pub fn run_trial(model: &Model, team: TeamSize, trial: &Trial) -> Outcome {
    let mut run = TrialRun::new(model, team, &trial.layout);
    while !run.is_over() {
        let rows = run.sense();
        run.advance(&std::array::from_fn(|i| trial.tables[i].get(rows[i])));
    }
    run.outcome()
}
