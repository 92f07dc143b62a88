//! What `atas demo` may be told.

use std::path::PathBuf;

use clap::{Args, Subcommand};

use super::values::html;

/// What the simulator's scenes have where nothing is said; a test holds them to it.
const OBJECT: &str = "wood";
const CAP: &str = "cap";
/// The table of `ebts evolve course` that ships.
pub(super) const COURSE_TABLE: &str = "course";

/// The tasks of `atas demo`.
#[derive(Debug, Subcommand)]
pub enum Demo {
    /// Grasp, lift and hold objects of known physics, and compare what became of them with what physics allows
    Grasp(DemoGrasp),
    /// Carry an object from one plate to another one and let go of it when it stands
    PickPlace(DemoPickPlace),
    /// Turn the cap of a clamped bottle until it is tight, and measure how tight
    Screw(DemoScrew),
    /// Hold a bottle with one hand, put a cap on it with the other, screw it tight and leave the bottle standing
    #[command(visible_alias = "assemble")]
    Assembly(DemoAssembly),
    /// Let a team of mobile robots carry its object to eight goals, each robot by an evolved behaviour table
    Swarm(DemoSwarm),
    /// Let a robot on wheels fetch an object, carry it to a goal and set it down: an evolved behaviour table drives, modules
    /// grasp. Every part a process, in virtual time
    Hybrid(DemoHybrid),
}

/// How a demo's processes run.
#[derive(Args, Clone, Debug)]
pub struct Running {
    /// The robot: one that ships (`atas robot list`), or a robot file
    #[arg(long, value_name = "NAME|FILE", default_value = super::values::ROBOT)]
    pub robot: String,
    /// Seed of the sensors' noise, and of what --vary draws
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
    /// Draw the objects' true properties and poses from their families, by the seed. Clients are told no more of it than
    /// the sizes of caps and bottles
    #[arg(long)]
    pub vary: bool,
    /// Tick by tick as fast as the machine goes, and the same bits every time
    #[arg(long, conflicts_with = "realtime")]
    pub lockstep: bool,
    /// By the clock at 1 kHz; the default
    #[arg(long)]
    pub realtime: bool,
    /// Show it in a browser: begins when the page is open, and stays until Ctrl-C
    #[arg(long)]
    pub dashboard: bool,
}

/// `atas demo grasp`.
#[derive(Args, Clone, Debug)]
pub struct DemoGrasp {
    /// A built-in object, or the file of one
    #[arg(long, value_name = "NAME|FILE", default_value = OBJECT, conflicts_with = "all")]
    pub object: String,
    /// Every built-in object, one after another
    #[arg(long, conflicts_with = "dashboard")]
    pub all: bool,
    /// How it runs
    #[command(flatten)]
    pub running: Running,
}

/// `atas demo pick-place`.
#[derive(Args, Clone, Debug)]
pub struct DemoPickPlace {
    /// A built-in object, or the file of one
    #[arg(long, value_name = "NAME|FILE", default_value = OBJECT)]
    pub object: String,
    /// How it runs
    #[command(flatten)]
    pub running: Running,
}

/// `atas demo screw`.
#[derive(Args, Clone, Debug)]
pub struct DemoScrew {
    /// A built-in cap, or the file of one
    #[arg(long, value_name = "NAME|FILE", default_value = CAP)]
    pub cap: String,
    /// How it runs
    #[command(flatten)]
    pub running: Running,
}

/// `atas demo assembly`.
#[derive(Args, Clone, Debug)]
pub struct DemoAssembly {
    /// A built-in cap, or the file of one
    #[arg(long, value_name = "NAME|FILE", default_value = CAP)]
    pub cap: String,
    /// How it runs
    #[command(flatten)]
    pub running: Running,
}

/// `atas demo swarm`.
#[derive(Args, Clone, Debug)]
pub struct DemoSwarm {
    /// A table file of `ebts evolve`, or the table that ships. Field and team are those it was evolved for
    #[arg(long, value_name = "NAME|FILE", default_value = "r3-two-agents")]
    pub table: String,
    /// Frames of the field per second
    #[arg(long, value_name = "HZ", default_value_t = 240, value_parser = clap::value_parser!(u32).range(1..=2000))]
    pub frame_rate_hz: u32,
    /// Show it in a browser: begins when the page is open, and stays until Ctrl-C
    #[arg(long, conflicts_with = "lockstep")]
    pub dashboard: bool,
    /// Frame by frame as fast as the machine goes
    #[arg(long, conflicts_with = "frame_rate_hz")]
    pub lockstep: bool,
    /// Write an animation of the eight trials: one web page that needs nothing else
    #[arg(long, value_name = "FILE.html", value_parser = html)]
    pub replay: Option<PathBuf>,
}

/// `atas demo hybrid`.
#[derive(Args, Clone, Debug)]
pub struct DemoHybrid {
    /// Robots on the course, 1 or 2
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u8).range(1..=2))]
    pub robots: u8,
    /// Seed of the course, the bumps of its floor, the object and the sensors' noise
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u64).range(..=1_000_000_000))]
    pub seed: u64,
    /// A table file of `ebts evolve course`, or the table that ships
    #[arg(long, value_name = "NAME|FILE", default_value = COURSE_TABLE)]
    pub table: String,
    /// A built-in object, or the file of one
    #[arg(long, value_name = "NAME|FILE", default_value = OBJECT)]
    pub object: String,
    /// Freeze the fingers once the object is lifted: what are the reflexes worth on the way?
    #[arg(long)]
    pub frozen: bool,
}

#[cfg(test)]
mod tests {
    #[test]
    fn a_demo_shows_what_the_simulator_usually_sets() {
        use sim_backend::Scene;
        assert_eq!([super::OBJECT, super::CAP], [Scene::OBJECT, Scene::CAP]);
        assert_eq!(super::super::values::ROBOT, robot_model::TWO_HAND_ARM.name);
    }
}
