//! Arguments of `atas demo`.

use std::path::PathBuf;

use clap::{Args, Subcommand};

use super::values::html;

/// Default object of the simulator's scenes; a test compares both.
const OBJECT: &str = "wood";
const CAP: &str = "cap";
/// Built-in table of `ebts evolve course`.
pub(super) const COURSE_TABLE: &str = "course";

/// Tasks of `atas demo`.
#[derive(Debug, Subcommand)]
pub enum Demo {
    /// Grasp, lift and hold simulated objects; compare each result with the physically possible one
    Grasp(DemoGrasp),
    /// Carry an object from one plate to another and release it there
    PickPlace(DemoPickPlace),
    /// Turn the cap of a clamped bottle until it is tight; report the torque
    Screw(DemoScrew),
    /// Hold a bottle with one hand, put a cap on with the other, screw it tight, set the bottle
    /// down
    #[command(visible_alias = "assemble")]
    Assembly(DemoAssembly),
    /// Transport an object to eight goals with mobile robots, each driven by an evolved behaviour
    /// table
    Swarm(DemoSwarm),
    /// Fetch an object with a wheeled robot, carry it to a goal and set it down
    ///
    /// An evolved behaviour table drives the base; tactile modules control the grasp. Each part is
    /// a process; time is virtual.
    Hybrid(DemoHybrid),
}

/// Options of a demo's processes.
#[derive(Args, Clone, Debug)]
pub struct DemoOptions {
    /// Robot: a built-in one (`atas robot list`) or a robot file
    #[arg(long, value_name = "NAME|FILE", value_parser = super::values::ROBOTS, hide_possible_values = true, default_value = super::values::ROBOT)]
    pub robot: String,
    /// Seed of the sensor noise and of --vary
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
    /// Draw object properties and poses from their families, by the seed
    ///
    /// Clients receive only the sizes of caps and bottles.
    #[arg(long)]
    pub vary: bool,
    /// Run tick by tick at full speed; results are reproducible bit by bit
    #[arg(long, conflicts_with = "realtime")]
    pub lockstep: bool,
    /// Run in real time at 1 kHz (default)
    #[arg(long)]
    pub realtime: bool,
    /// Physics engine of the simulator [default: built-in]
    ///
    /// As in `atas-sim run`: "mujoco --viewer" shows a window, "mujoco --pictures FOLDER" writes
    /// pictures. Use --lockstep if the machine is slower than real time.
    #[arg(long, value_name = "COMMAND")]
    pub engine: Option<String>,
    /// Show the demo in a browser: starts when the page is open, runs until Ctrl-C
    #[arg(long)]
    pub dashboard: bool,
}

/// `atas demo grasp`.
#[derive(Args, Clone, Debug)]
pub struct DemoGrasp {
    /// Built-in object or object file
    #[arg(long, value_name = "NAME|FILE", value_parser = super::values::OBJECTS, hide_possible_values = true, default_value = OBJECT, conflicts_with = "all")]
    pub object: String,
    /// All built-in objects in turn
    #[arg(long, conflicts_with = "dashboard")]
    pub all: bool,
    /// Process options
    #[command(flatten)]
    pub running: DemoOptions,
}

/// `atas demo pick-place`.
#[derive(Args, Clone, Debug)]
pub struct DemoPickPlace {
    /// Built-in object or object file
    #[arg(long, value_name = "NAME|FILE", value_parser = super::values::OBJECTS, hide_possible_values = true, default_value = OBJECT)]
    pub object: String,
    /// Process options
    #[command(flatten)]
    pub running: DemoOptions,
}

/// `atas demo screw`.
#[derive(Args, Clone, Debug)]
pub struct DemoScrew {
    /// Built-in cap or cap file
    #[arg(long, value_name = "NAME|FILE", default_value = CAP)]
    pub cap: String,
    /// Process options
    #[command(flatten)]
    pub running: DemoOptions,
}

/// `atas demo assembly`.
#[derive(Args, Clone, Debug)]
pub struct DemoAssembly {
    /// Built-in cap or cap file
    #[arg(long, value_name = "NAME|FILE", default_value = CAP)]
    pub cap: String,
    /// Process options
    #[command(flatten)]
    pub running: DemoOptions,
}

/// `atas demo swarm`.
#[derive(Args, Clone, Debug)]
pub struct DemoSwarm {
    /// Table file of `ebts evolve`, or built-in table; it sets field and team
    #[arg(long, value_name = "NAME|FILE", default_value = "r3-two-agents")]
    pub table: String,
    /// Field frames per second
    #[arg(long, value_name = "HZ", default_value_t = 240, value_parser = clap::value_parser!(u32).range(1..=2000))]
    pub frame_rate_hz: u32,
    /// Show the demo in a browser: starts when the page is open, runs until Ctrl-C
    #[arg(long, conflicts_with = "lockstep")]
    pub dashboard: bool,
    /// Run frame by frame at full speed
    #[arg(long, conflicts_with = "frame_rate_hz")]
    pub lockstep: bool,
    /// Write an animation of the eight trials as a self-contained web page
    #[arg(long, value_name = "FILE.html", value_parser = html)]
    pub replay: Option<PathBuf>,
}

/// `atas demo hybrid`.
#[derive(Args, Clone, Debug)]
pub struct DemoHybrid {
    /// Robots on the course, 1 or 2
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u8).range(1..=2))]
    pub robots: u8,
    /// Seed of course, floor bumps, object and sensor noise
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u64).range(..=1_000_000_000))]
    pub seed: u64,
    /// Table file of `ebts evolve course`, or built-in table
    #[arg(long, value_name = "NAME|FILE", default_value = COURSE_TABLE)]
    pub table: String,
    /// Built-in object or object file
    #[arg(long, value_name = "NAME|FILE", value_parser = super::values::OBJECTS, hide_possible_values = true, default_value = OBJECT)]
    pub object: String,
    /// Freeze the fingers after the lift, to measure the benefit of the tactile reflexes
    #[arg(long)]
    pub frozen: bool,
    /// Run in lock-step, in virtual time; the only mode of this demo
    #[arg(long)]
    pub lockstep: bool,
}

#[cfg(test)]
mod tests {
    #[test]
    fn demo_defaults_match_the_simulator() {
        use sim_backend::Scene;
        assert_eq!([super::OBJECT, super::CAP], [Scene::OBJECT, Scene::CAP]);
        assert_eq!(super::super::values::ROBOT, robot_model::TWO_HAND_ARM.name);
    }
}
