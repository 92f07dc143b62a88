//! Demos of robot teams: each component in a separate process, an evaluation by ground truth.
//!
//! ```text
//!  swarm ─ one evolved table ─▶ child: atas-sim field, ebts agents ─▶ outcome per goal
//!            └─ page of atas-demo, with --dashboard
//!  hybrid ─ child: atas-sim course; per robot a bus ─ child: atasd, ebts agents ─▶ coordinators
//! ```

mod hybrid;
mod swarm;

use atas_console::arguments::Demo;
use atas_console::{Interrupt, Output};

pub(crate) fn demo(task: &Demo, interrupt: &Interrupt, output: &mut Output) -> anyhow::Result<()> {
    match task {
        Demo::Swarm(arguments) => swarm::swarm(arguments, interrupt, output),
        Demo::Hybrid(arguments) => hybrid::hybrid(arguments, interrupt, output),
        one_robot => atas_demo::demo(one_robot, interrupt, output),
    }
}
