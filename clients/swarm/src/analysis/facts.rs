//! Facts of every trial of a run: pushing, circling and passive agents.

use serde::Serialize;

use field::{MAX_AGENTS, delivered};

use super::trace::{Trace, trace};
use super::wandering::{PUSHING_FRAMES, pushing_frames, wandering};
use crate::condition::Condition;
use crate::genome::Genome;
use crate::run::Record;

/// Facts of one trial.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct TrialFacts {
    /// Team size.
    pub agents: usize,
    /// Seed of the run.
    pub seed: u64,
    /// Goal, from 1.
    pub goal: usize,
    /// Points by the fitness rule of the run.
    pub points: f32,
    /// The object is at the goal and an agent stayed with it, independent of the rule.
    pub delivered: bool,
    /// First frame at the goal; 0 if never reached.
    pub reached_frame: u32,
    /// Distance from object to goal after frame 270.
    pub distance_px: f32,
    /// Facts of each agent.
    #[serde(skip)]
    pub each: [AgentFacts; MAX_AGENTS],
}

/// Facts of one agent in a trial.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct AgentFacts {
    /// Frames in which the agent presses against the object.
    pub pushing_frames: usize,
    /// The agent circles, see [`super::Wandering`].
    pub circling: bool,
    /// The agent stays trapped (paper III.c.1).
    pub trapped: bool,
}

impl AgentFacts {
    /// Returns whether the agent took part in carrying.
    #[must_use]
    pub fn pushes(&self) -> bool {
        self.pushing_frames >= PUSHING_FRAMES
    }
}

impl TrialFacts {
    /// Extracts the facts of one trial of a run.
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

    /// Returns the agents of the team.
    #[must_use]
    pub fn each(&self) -> &[AgentFacts] {
        &self.each[..self.agents]
    }

    /// Returns the number of agents that took part in pushing.
    #[must_use]
    pub fn pushers(&self) -> usize {
        self.each().iter().filter(|agent| agent.pushes()).count()
    }

    /// Returns the frames in which agents that do not carry touch the object.
    #[must_use]
    pub fn interference(&self) -> usize {
        let others = self.each().iter().filter(|agent| !agent.pushes());
        others.map(|agent| agent.pushing_frames).sum()
    }
}

/// Returns the trials of a run, goal 1 first; empty if its genome does not fit the condition.
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
