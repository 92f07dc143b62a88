//! Command line of `atas-sim course`.

use atas_process::exit::Exit;
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
#[command(after_help = format!("{EXAMPLES}\n{}\n{}", Exit::TABLE, Failure::NOTES))]
pub(crate) struct CourseArgs {
    /// Seed of the course, its floor, the objects and the sensor noise.
    #[arg(long, default_value_t = 1)]
    pub(super) seed: u64,
    /// Object of a robot: a built-in name or a TOML file; once per robot, at most twice.
    #[arg(long = "object", value_name = "NAME|FILE", default_value = Scene::OBJECT)]
    objects: Vec<String>,
    /// Bus of the first robot.
    #[arg(long, env = BusName::ENV, default_value_t)]
    bus: BusName,
    /// Bus of the second robot.
    #[arg(long, value_name = "BUS")]
    second_bus: Option<BusName>,
    /// Output format.
    #[arg(long, value_enum, default_value = "human")]
    pub(super) format: Format,
}

impl CourseArgs {
    pub(super) fn objects(&self) -> Result<Vec<Object>, Failure> {
        let objects = self
            .objects
            .iter()
            .map(|name| Object::from_name_or_file(name));
        Ok(objects.collect::<Result<_, _>>()?)
    }

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
