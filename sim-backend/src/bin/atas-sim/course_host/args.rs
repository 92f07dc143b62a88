//! The command line of `atas-sim course`.

use clap::Args;
use shm_bus::BusName;
use sim_backend::{Object, Scene};

use crate::failure::Failure;
use crate::output::Format;

const EXAMPLES: &str = "\
Examples:
  atas-sim course --seed 2 --object bottle
  atas-sim course --object wood --bus first --object sponge --second-bus second
";

#[derive(Debug, Args)]
#[command(after_help = format!("{EXAMPLES}\n{}", Failure::EXIT_CODES))]
pub(crate) struct CourseArgs {
    /// Seed of the course, the bumps of its floor, the objects and the sensors' noise.
    #[arg(long, default_value_t = 1)]
    pub(super) seed: u64,
    /// What a robot has to fetch: a built-in name or a TOML file. Once for every robot, at most twice.
    #[arg(long = "object", value_name = "NAME|FILE", default_value = Scene::OBJECT)]
    objects: Vec<String>,
    /// Bus of the robot, of two that of the first.
    #[arg(long, env = BusName::ENV, default_value_t)]
    bus: BusName,
    /// Bus of the second robot.
    #[arg(long, value_name = "BUS")]
    second_bus: Option<BusName>,
    /// How results are printed.
    #[arg(long, value_enum, default_value = "human")]
    pub(super) format: Format,
}

impl CourseArgs {
    /// What the robots have to fetch.
    pub(super) fn objects(&self) -> Result<Vec<Object>, Failure> {
        let objects = self.objects.iter().map(|name| Object::named_or_file(name));
        Ok(objects.collect::<Result<_, _>>()?)
    }

    /// Their buses.
    pub(super) fn buses(&self) -> Result<Vec<BusName>, Failure> {
        let buses: Vec<BusName> = std::iter::once(&self.bus)
            .chain(&self.second_bus)
            .cloned()
            .collect();
        match (self.objects.len(), buses.len()) {
            (objects, buses) if objects != buses => Err(Failure::Buses { objects, buses }),
            _ => Ok(buses),
        }
    }
}
