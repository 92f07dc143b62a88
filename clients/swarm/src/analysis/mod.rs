//! Analysis of evolved teams: behaviour, and findings of the paper (III.c) with intervals.

mod baseline;
mod claim;
mod comparison;
mod facts;
mod fig17;
mod findings;
mod held_out;
mod trace;
mod transfer;
mod wandering;

pub use baseline::{Baselines, baselines, hand_written};
pub use claim::Claim;
pub use comparison::{Comparison, comparisons};
pub use facts::{AgentFacts, TrialFacts, facts};
pub use fig17::{Case, examples};
pub use findings::{Findings, Order, Redundancy, Single, Verdict, findings};
pub use held_out::{HeldOut, held_out};
pub use trace::{Frame, Trace, trace};
pub use transfer::{Transfer, UNSEEN_SETS, transfer, transfers};
pub use wandering::{Wandering, pushing_frames, wandering};

use field::{Engine, Layout, MAX_AGENTS, Responses, Trial};

use crate::condition::Condition;

fn points_in(
    condition: &Condition,
    engine: Engine,
    responses: [Responses; MAX_AGENTS],
    layouts: &[Layout],
) -> f32 {
    let trials: Vec<Trial> = layouts
        .iter()
        .map(|&layout| Trial {
            layout,
            tables: responses,
        })
        .collect();
    let mut outcomes = Vec::new();
    engine.run(&condition.model, condition.team, &trials, &mut outcomes);
    outcomes
        .iter()
        .fold(0.0, |sum, outcome| sum + condition.points(outcome))
}
