//! Frame-by-frame trace of one trial, from the scalar reference simulator.

use field::{Layout, MAX_AGENTS, Outcome, Point, Pose, Responses, TRIAL_FRAMES, TrialRun, Wheels};

use crate::condition::Condition;

/// State of the field in one frame.
#[derive(Clone, Debug)]
pub struct Frame {
    /// Poses of the agents.
    pub agents: Vec<Pose>,
    /// Centre of the object.
    pub object: Point,
    /// Table row of each agent.
    pub rows: Vec<usize>,
    /// Wheel levels of each agent.
    pub wheels: Vec<Wheels>,
    /// Per agent: contact with the object during the last step.
    pub touching: Vec<bool>,
}

/// A complete trial: frame 0 is the start, frame 270 the end.
#[derive(Clone, Debug)]
pub struct Trace {
    /// Goal of the object.
    pub goal: Point,
    /// 271 frames.
    pub frames: Vec<Frame>,
    /// Result of the trial.
    pub outcome: Outcome,
}

/// Simulates one trial of a team.
#[must_use]
pub fn trace(condition: &Condition, responses: [Responses; MAX_AGENTS], layout: &Layout) -> Trace {
    let mut run = TrialRun::new(&condition.model, condition.team, layout);
    let mut frames = Vec::with_capacity(TRIAL_FRAMES as usize + 1);
    for _ in 0..=TRIAL_FRAMES {
        // The last frame is recorded, but the agents no longer act on it.
        let field_rows = if run.is_over() {
            run.world().sense()
        } else {
            run.sense()
        };
        let wheels = std::array::from_fn(|i| responses[i].get(field_rows[i]));
        let (n, world) = (condition.team.get(), run.world());
        frames.push(Frame {
            agents: world.agents().to_vec(),
            object: world.object(),
            rows: field_rows[..n]
                .iter()
                .map(|&row| condition.sensors.table_row(row))
                .collect(),
            wheels: wheels[..n].to_vec(),
            touching: world.touching()[..n].to_vec(),
        });
        run.advance(&wheels);
    }
    Trace {
        goal: layout.goal(),
        frames,
        outcome: run.outcome(),
    }
}
