//! What every trial of a run shows: who pushed, circled, kept out.

use serde::Serialize;

use field::{MAX_AGENTS, delivered};

use super::trace::{Trace, trace};
use super::wandering::{PUSHING_FRAMES, pushing_frames, wandering};
use crate::condition::Condition;
use crate::genome::Genome;
use crate::run::Record;

/// What one trial shows.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct TrialFacts {
    /// Team size.
    pub agents: usize,
    /// Seed of the run.
    pub seed: u64,
    /// From 1.
    pub goal: usize,
    /// By the run's fitness rule.
    pub points: f32,
    /// The object is at the goal, and an agent stayed with it (whatever the rule).
    pub delivered: bool,
    /// First frame at the goal; 0 if never.
    pub reached_frame: u32,
    /// From object to goal after frame 270.
    pub distance_px: f32,
    /// What each agent did.
    #[serde(skip)]
    pub each: [AgentFacts; MAX_AGENTS],
}

/// What one agent does in a trial.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct AgentFacts {
    /// Frames in which it presses against the object.
    pub pushing_frames: usize,
    /// See [`super::Wandering`].
    pub circling: bool,
    /// It does not get away (paper III.c.1).
    pub trapped: bool,
}

impl AgentFacts {
    /// It took part in carrying.
    #[must_use]
    pub fn pushes(&self) -> bool {
        self.pushing_frames >= PUSHING_FRAMES
    }
}

impl TrialFacts {
    /// Of one trial of a run.
    #[must_use]
    pub fn new(condition: &Condition, record: &Record, goal: usize, trace: &Trace) -> Self {
        let mut each = [AgentFacts::default(); MAX_AGENTS];
        for (agent, facts) in each.iter_mut().enumerate().take(record.agents) {
            let wandering = wandering(condition, trace, agent);
            *facts = AgentFacts {
                pushing_frames: pushing_frames(trace, agent),
                circling: wandering.circling,
                trapped: wandering.trapped(),
            };
        }
        Self {
            agents: record.agents,
            seed: record.seed,
            goal: goal + 1,
            points: condition.points(&trace.outcome),
            delivered: delivered(condition.model.preset(), condition.team, &trace.outcome),
            reached_frame: trace.outcome.reached_frame,
            distance_px: trace.outcome.evaluated.goal_px,
            each,
        }
    }

    /// The agents that take part.
    #[must_use]
    pub fn each(&self) -> &[AgentFacts] {
        &self.each[..self.agents]
    }

    /// How many agents took part in pushing.
    #[must_use]
    pub fn pushers(&self) -> usize {
        self.each().iter().filter(|agent| agent.pushes()).count()
    }

    /// Frames in which those who do not carry touch the object all the same.
    #[must_use]
    pub fn interference(&self) -> usize {
        let others = self.each().iter().filter(|agent| !agent.pushes());
        others.map(|agent| agent.pushing_frames).sum()
    }
}

/// The trials of a run, goal 1 first; none if its genome does not fit the condition.
#[must_use]
pub fn facts(condition: &Condition, record: &Record) -> Vec<TrialFacts> {
    let Some(genome) = Genome::from_hex(condition.genome_bits(), &record.genome) else {
        return Vec::new();
    };
    let responses = condition.responses(&genome);
    let layouts = condition.layouts();
    let of_goal = |(goal, layout)| {
        let trace = trace(condition, responses, layout);
        TrialFacts::new(condition, record, goal, &trace)
    };
    layouts.iter().enumerate().map(of_goal).collect()
}
