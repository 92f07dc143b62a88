//! Demos: the real processes on a bus of their own, a goal, and the judgement by physical truth.
//!
//! ```text
//!  mod ── one object after another ─▶ performance ─┬─ stage ── child: atas-sim, atasd     (ends and wipes on drop)
//!                                                  ├─ client::Pursuit: the goal, as any client would send it
//!                                                  └─ judge: what the simulator's truth says of the outcome
//! ```
//!  swarm ─ one evolved table ─▶ child: atas-sim field, ebts agents ─▶ outcome per goal, against what evolution saw
//!
//! A demo is a client like any other: it uses nothing of the daemon but the bus.

mod child;
mod logs;
mod performance;
mod stage;
mod swarm;
mod table;

use sim_backend::Object;

use crate::arguments::DemoGrasp;
use crate::exit::{Ended, Exit};
use crate::interrupt::Interrupt;
use crate::output::Output;
use performance::Performance;

pub(crate) use swarm::swarm;

/// `atas demo grasp`.
pub(crate) fn grasp(
    arguments: &DemoGrasp,
    interrupt: &Interrupt,
    output: &mut Output,
) -> anyhow::Result<()> {
    let objects: Vec<&str> = if arguments.all {
        Object::names().collect()
    } else {
        vec![&arguments.object]
    };
    let mut performances = Vec::new();
    let mut ended = Ok(());
    for object in objects {
        match Performance::of(object, arguments.seed, arguments.lockstep, interrupt) {
            Ok(performance) => performances.push(performance),
            Err(error) => {
                ended = Err(error);
                break;
            }
        }
    }
    // What was performed before an error is worth seeing.
    if !performances.is_empty() {
        table::print(&performances, output)?;
    }
    ended?;
    verdict(&performances)
}

/// An error that names what did not end as physics says it should.
fn verdict(performances: &[Performance]) -> anyhow::Result<()> {
    let unexpected: Vec<String> = performances
        .iter()
        .filter(|performance| !performance.is_expected())
        .map(|performance| {
            let should = if performance.load.is_feasible() {
                "held"
            } else {
                "refused"
            };
            format!(
                "{}: {}, should be {should}",
                performance.object,
                performance.outcome.name()
            )
        })
        .collect();
    if unexpected.is_empty() {
        return Ok(());
    }
    Err(Ended::with(Exit::Unexpected, unexpected.join("; ")))
}
