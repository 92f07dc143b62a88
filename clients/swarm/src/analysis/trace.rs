//! One trial, frame by frame, with the scalar reference.

use field::{Layout, MAX_AGENTS, Outcome, Point, Pose, Responses, TRIAL_FRAMES, TrialRun, Wheels};

use crate::condition::Condition;

/// The field at one instant.
#[derive(Clone, Debug)]
pub struct Frame {
    /// The agents that take part.
    pub agents: Vec<Pose>,
    /// The object's centre.
    pub object: Point,
    /// Per agent the table row that its sensors select now.
    pub rows: Vec<usize>,
    /// Per agent its wheel levels now.
    pub wheels: Vec<Wheels>,
    /// Per agent whether it pressed against the object to get here.
    pub touching: Vec<bool>,
}

/// A whole trial: frame 0 is the start, frame 270 the end.
#[derive(Clone, Debug)]
pub struct Trace {
    /// Where the object should go.
    pub goal: Point,
    /// 271 instants.
    pub frames: Vec<Frame>,
    /// What the trial came to.
    pub outcome: Outcome,
}

/// Follows a team through one trial.
#[must_use]
pub fn trace(condition: &Condition, responses: [Responses; MAX_AGENTS], layout: &Layout) -> Trace {
    let mut run = TrialRun::new(&condition.model, condition.team, layout);
    let mut frames = Vec::with_capacity(TRIAL_FRAMES as usize + 1);
    for _ in 0..=TRIAL_FRAMES {
        // The last instant is looked at, but nothing is read in it any more.
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
