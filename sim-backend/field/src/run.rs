//! A trial under way: stepped from outside, frame by frame, with its outcome so far.

use crate::model::{Model, TeamSize};
use crate::responses::Wheels;
use crate::trial::{EXECUTION_FRAMES, Layout, MAX_AGENTS, Outcome, TRIAL_FRAMES, Trial};
use crate::world::World;

/// One trial, simulated by the scalar reference: alternately [`TrialRun::sense`] and [`TrialRun::advance`].
#[derive(Clone, Debug)]
pub struct TrialRun {
    world: World,
    team: TeamSize,
    frame: u32,
    outcome: Outcome,
}

impl TrialRun {
    /// A trial before its first frame.
    #[must_use]
    pub fn new(model: &Model, team: TeamSize, layout: &Layout) -> Self {
        Self {
            world: World::new(model, team, layout),
            team,
            frame: 0,
            outcome: Outcome::default(),
        }
    }

    /// The row that every agent's sensors select now, as [`World::sense`]; the outcome remembers it.
    pub fn sense(&mut self) -> [u8; MAX_AGENTS] {
        let rows = self.world.sense();
        for row in &rows[..self.team.get()] {
            self.outcome.rows_read |= 1 << row;
        }
        rows
    }

    /// One frame at these wheel levels. A trial that is over stays as it is.
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

    /// Frames that are over.
    #[must_use]
    pub fn frame(&self) -> u32 {
        self.frame
    }

    /// Whether all frames of the trial are over.
    #[must_use]
    pub fn is_over(&self) -> bool {
        self.frame == TRIAL_FRAMES
    }

    /// What it came to so far; complete when it [is over](TrialRun::is_over).
    #[must_use]
    pub fn outcome(&self) -> Outcome {
        self.outcome
    }

    /// The field as it is now.
    #[must_use]
    pub fn world(&self) -> &World {
        &self.world
    }
}

/// Simulates one trial with the scalar reference.
#[must_use]
pub fn run_trial(model: &Model, team: TeamSize, trial: &Trial) -> Outcome {
    let mut run = TrialRun::new(model, team, &trial.layout);
    while !run.is_over() {
        let rows = run.sense();
        run.advance(&std::array::from_fn(|i| trial.tables[i].get(rows[i])));
    }
    run.outcome()
}
