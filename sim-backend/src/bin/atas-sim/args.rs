//! The command line: what may be said, and the scene it amounts to.

use std::path::PathBuf;
use std::str::FromStr;
use std::time::Duration;

use clap::{Args, Parser, Subcommand, ValueEnum};
use robot_model::Side;
use shm_bus::BusName;
use sim_backend::faults::Fault;
use sim_backend::{Object, Placed, Scene};

use crate::failure::Failure;
use crate::field_host::FieldArgs;

/// A simulated two-hand robot with tactile fingertips before a table of objects.
#[derive(Debug, Parser)]
#[command(name = "atas-sim", version, after_help = Failure::EXIT_CODES)]
pub(crate) struct Cli {
    #[command(subcommand)]
    pub(crate) command: Command,
}

#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Simulate: publish frames, joint states and truth; obey the daemon's commands.
    Run(RunArgs),
    /// Host the swarm's field: publish what its robots sense, obey `ebts agents`, say what became of every goal.
    Field(FieldArgs),
    /// List the built-in objects.
    Objects,
    /// List the faults that `run --fault` can inject.
    Faults,
}

#[derive(Debug, Args)]
#[command(after_help = Failure::EXIT_CODES)]
pub(crate) struct RunArgs {
    /// Object on the table: a built-in name or a TOML file, optionally with its place. May be given up to four times.
    #[arg(long = "object", value_name = "NAME|FILE[@X,Y[,YAW]]  (m, m, degrees)")]
    objects: Vec<ObjectArg>,
    /// Hand in front of which objects without a place stand.
    #[arg(long, value_enum, default_value = "right")]
    hand: HandArg,
    /// Seed of noise, tremble, families and faults.
    #[arg(long, default_value_t = 1)]
    pub(crate) seed: u64,
    /// Draw the objects' true mass, friction, stiffness and pose from their families, by the seed.
    #[arg(long)]
    vary: bool,
    /// Scale of the fingertip sensors' noise.
    #[arg(long, default_value_t = 1.0)]
    noise: f64,
    /// Frames per second of the fingertip sensors, 1 to 1000.
    #[arg(long, default_value_t = 1000)]
    rate_hz: u32,
    /// Wait for the daemon's answer to every tick: virtual time, repeatable bit for bit.
    #[arg(long)]
    pub(crate) lockstep: bool,
    /// Bus to publish on.
    #[arg(long, env = BusName::ENV, default_value_t)]
    pub(crate) bus: BusName,
    /// End after so many seconds of simulated time.
    #[arg(long, value_name = "SECONDS", value_parser = seconds)]
    pub(crate) duration: Option<Duration>,
    /// Inject a fault, see `atas-sim faults`. May be given several times.
    #[arg(long = "fault", value_name = "FAULT")]
    pub(crate) faults: Vec<Fault>,
    /// Robot to simulate: a URDF of the built-in robot's structure.
    #[arg(long, value_name = "URDF")]
    pub(crate) robot: Option<PathBuf>,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum HandArg {
    Left,
    Right,
}

impl HandArg {
    fn side(self) -> Side {
        match self {
            Self::Left => Side::Left,
            Self::Right => Side::Right,
        }
    }
}

/// What an object is called, and where it stands if that was said.
#[derive(Clone, Debug, PartialEq)]
struct ObjectArg {
    name: String,
    place: Option<([f64; 2], f64)>,
}

impl FromStr for ObjectArg {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let Some((name, place)) = text.rsplit_once('@') else {
            return Ok(Self {
                name: text.into(),
                place: None,
            });
        };
        let numbers: Result<Vec<f64>, _> = place.split(',').map(str::parse).collect();
        let (position_m, yaw_deg) = match numbers.as_deref() {
            Ok([x, y]) => ([*x, *y], 90.0),
            Ok([x, y, yaw_deg]) => ([*x, *y], *yaw_deg),
            _ => {
                return Err(format!(
                    "its place was {place:?}, needs X,Y or X,Y,YAW in metres and degrees"
                ));
            }
        };
        Ok(Self {
            name: name.into(),
            place: Some((position_m, yaw_deg.to_radians())),
        })
    }
}

fn seconds(text: &str) -> Result<Duration, String> {
    let seconds: f64 = text
        .parse()
        .map_err(|_| "needs a number of seconds".to_owned())?;
    Duration::try_from_secs_f64(seconds).map_err(|error| error.to_string())
}

impl RunArgs {
    /// The scene that the arguments describe.
    pub(crate) fn scene(&self) -> Result<Scene, Failure> {
        let mut scene = Scene {
            noise_factor: self.noise,
            sensor_rate_hz: [self.rate_hz; 2],
            ..Scene::default()
        };
        for ObjectArg { name, place } in &self.objects {
            let object = Object::named_or_file(name)?;
            scene.objects.push(match *place {
                Some((position_m, yaw_rad)) => Placed::new(object, position_m, yaw_rad),
                None => Placed::before(object, self.hand.side()),
            });
        }
        Ok(if self.vary {
            scene.varied(self.seed)
        } else {
            scene
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scene(arguments: &str) -> Result<Scene, String> {
        let words = ["atas-sim", "run"]
            .into_iter()
            .chain(arguments.split_whitespace());
        match Cli::try_parse_from(words)
            .map_err(|error| error.to_string())?
            .command
        {
            Command::Run(args) => args.scene().map_err(|failure| failure.to_string()),
            other => Err(format!("{other:?}")),
        }
    }

    #[test]
    fn places() {
        let placed = &scene("--object bottle@0.3,-0.1,45 --object wood --hand left")
            .expect("a scene")
            .objects;
        assert_eq!(
            (placed[0].position_m, placed[0].yaw_rad),
            ([0.3, -0.1], 45_f64.to_radians())
        );
        assert!(placed[1].position_m[1] > 0.0, "in front of the left hand");
    }

    #[test]
    fn refusals_say_what_to_do() {
        let check = |arguments: &str, part: &str| {
            let message = scene(arguments).expect_err(arguments);
            assert!(message.contains(part), "{arguments}: {message}");
        };
        check("--object botle", "did you mean \"bottle\"?");
        check("--object wood@here", "needs X,Y or X,Y,YAW");
        check("--object /no/such.toml", "check the path");
        check("--fault drop", "needs KIND[=VALUE]@START");
        check("--bus ATAS!", "use 1 to 24 characters");
        check("--duration=-1", "negative");
        check("--seed x", "invalid digit");
    }
}
