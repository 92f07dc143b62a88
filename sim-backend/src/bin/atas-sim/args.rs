//! Command line of `atas-sim`.

use std::path::PathBuf;
use std::time::Duration;

use atas_process::exit::Exit;
use clap::{Args, Parser, Subcommand};
use robot_model::{RobotModel, TWO_HAND_ARM};
use shm_bus::BusName;
use sim_backend::Scene;
use sim_backend::engine::EngineCommand;
use sim_backend::faults::Fault;

use crate::course_host::CourseArgs;
use crate::failure::Failure;
use crate::field_host::FieldArgs;
use crate::output::Format;
use crate::scene_args::SceneArgs;

/// Simulate two-hand robots with tactile fingertips, robots on wheels, and the swarm's field.
#[derive(Debug, Parser)]
#[command(name = "atas-sim", version, long_version = shm_bus::long_version(), after_help = format!("{EXAMPLES}\n{}\n{}", Exit::TABLE, Failure::NOTES))]
pub(crate) struct Cli {
    #[command(subcommand)]
    pub(crate) command: Command,
}

#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Simulate a robot at a table: publish tactile frames, joint states and ground truth; execute
    /// the daemon's commands.
    Run(Box<RunArgs>),
    /// Host the swarm's field: publish the robots' sensors, execute the wheel commands of
    /// `ebts agents`, report every goal.
    Field(FieldArgs),
    /// Host a course in lock-step: two-hand arms on wheeled bases, each carrying an object to a
    /// goal.
    Course(CourseArgs),
    /// List the built-in objects.
    #[command(after_help = OBJECTS_HELP)]
    Objects {
        /// Output format.
        #[arg(long, value_enum, default_value = "human")]
        format: Format,
    },
    /// List the faults that `run --fault` can inject.
    #[command(after_help = "Example:\n  atas-sim faults")]
    Faults,
    /// List the errors that `run --errors` and `atas eval --errors` can apply.
    #[command(after_help = "Example:\n  atas-sim errors")]
    Errors,
    /// List the built-in sensor models, or print the file of one with the sources of its values.
    #[command(after_help = SENSORS_HELP)]
    Sensors {
        /// Built-in model whose file is printed.
        name: Option<String>,
        /// Output format of the list.
        #[arg(long, value_enum, default_value = "human")]
        format: Format,
    },
    /// Print completions for a shell.
    #[command(
        after_help = "Example:\n  atas-sim completions bash > /etc/bash_completion.d/atas-sim"
    )]
    Completions {
        /// Shell.
        shell: clap_complete::Shell,
    },
    /// Write the manual pages into a folder.
    #[command(after_help = "Example:\n  atas-sim man /usr/local/share/man/man1")]
    Man {
        /// Folder; created if missing.
        folder: PathBuf,
    },
}

const EXAMPLES: &str = "\
Examples:
  atas-sim run --object wood
  atas-sim field --goal 3
  atas-sim course --seed 2
  atas-sim objects
  atas-sim faults
  atas-sim sensors
";

const OBJECTS_HELP: &str = "\
JSON, one object per line: {name, mass_kg, width_m, height_m, friction, needed_n, stiffness_n_m, crush_n}; \
without stiffness_n_m the object is rigid, without crush_n it cannot be crushed.

Examples:
  atas-sim objects
  atas-sim objects --format json";

const SENSORS_HELP: &str = "\
JSON, one model per line: {name, model}; model has the keys of a model file.

Examples:
  atas-sim sensors
  atas-sim sensors optoforce-omd20 > my-sensor.toml
  atas-sim sensors --format json";

const RUN_EXAMPLES: &str = "\
Examples:
  atas-sim run --object wood
  atas-sim run --object wood --robot test-bench
  atas-sim run --scene assembly --vary --seed 7
  atas-sim run --object wood --errors crosstalk=3,centre-of-mass
  atas-sim run --object wood --engine \"mujoco --viewer\"
  atas-sim run --object wood --sensor-model my-sensor.toml --errors creep
  atas-sim run --object bottle@0.3,-0.1,45 --lockstep --duration 20 --fault drop=0.3@2+0.5:right
";

#[derive(Debug, Args)]
#[command(after_help = format!("{RUN_EXAMPLES}\n{}\n{}", Exit::TABLE, Failure::NOTES))]
pub(crate) struct RunArgs {
    #[command(flatten)]
    scene: SceneArgs,
    /// Seed of noise, tremble, random properties and faults.
    #[arg(long, default_value_t = 1)]
    pub(crate) seed: u64,
    /// Wait for the daemon's response to every tick: virtual time, bit-identical runs.
    #[arg(long)]
    pub(crate) lockstep: bool,
    /// Bus to publish on.
    #[arg(long, env = BusName::ENV, default_value_t)]
    pub(crate) bus: BusName,
    /// Stop after this simulated time, in seconds.
    #[arg(long, value_name = "SECONDS", value_parser = seconds)]
    pub(crate) duration: Option<Duration>,
    /// Inject a fault, see `atas-sim faults`; repeatable.
    #[arg(long = "fault", value_name = "FAULT")]
    pub(crate) faults: Vec<Fault>,
    /// Robot to simulate: a built-in one (`atas robot list`) or a robot file.
    #[arg(long, value_name = "NAME|FILE", default_value_t = TWO_HAND_ARM.name.to_string())]
    pub(crate) robot: String,
    /// Physics engine in a process of its own: `mujoco` with its options, or a program
    ///
    /// MuJoCo needs `pip install 'atas[mujoco]'`; ATAS_PYTHON names another interpreter.
    #[arg(long, value_name = "mujoco|PROGRAM [OPTIONS]")]
    pub(crate) engine: Option<EngineCommand>,
}

fn seconds(text: &str) -> Result<Duration, String> {
    let seconds: f64 = text
        .parse()
        .map_err(|_| "needs a number of seconds".to_owned())?;
    Duration::try_from_secs_f64(seconds).map_err(|error| error.to_string())
}

impl RunArgs {
    pub(crate) fn scene(&self, robot: &RobotModel) -> Result<Scene, Failure> {
        self.scene.scene(robot, self.seed)
    }

    /// Client command for the task of the scene, if any.
    pub(crate) fn example_command(&self, robot: &RobotModel, scene: &Scene) -> Option<String> {
        self.scene.example_command(robot, scene)
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
            Command::Run(args) => {
                let robot = RobotModel::find(&args.robot).map_err(|error| error.to_string())?;
                args.scene(&robot).map_err(|failure| failure.to_string())
            }
            other => Err(format!("{other:?}")),
        }
    }

    #[test]
    fn example_command_matches_the_scene() {
        let check = |arguments: &str, expected: Option<&str>| {
            let words = ["atas-sim", "run"].into_iter();
            let cli = Cli::try_parse_from(words.chain(arguments.split_whitespace())).unwrap();
            let Command::Run(args) = cli.command else {
                panic!("{arguments}");
            };
            let robot = RobotModel::find(&args.robot).unwrap();
            let scene = args.scene(&robot).unwrap();
            let command = args.example_command(&robot, &scene);
            assert_eq!(command.as_deref(), expected, "{arguments}");
        };
        check("", None);
        check(
            "--object wood --hand left",
            Some("atas grasp --at 0.320,0.150,0.0345 --width 50.0 --yaw 90 --hand left"),
        );
        check(
            "--scene pick-place",
            Some(
                "atas pick-place --from 0.320,-0.150,0.0445 --to 0.320,-0.270,0.0445 --width 50.0 --yaw 90",
            ),
        );
        check(
            "--scene screw --robot arm7-gripper",
            Some("atas screw --at 0.319,0.030,0.1200 --width 30.0 --yaw 90"),
        );
        check(
            "--scene assembly",
            Some(
                "atas assemble --cap 0.320,-0.180,0.0500 --cap-width 30.0 --on 0.380,0.000,0.1200 --bottle-width 60.0 --yaw 60",
            ),
        );
    }

    #[test]
    fn objects_stand_at_given_or_default_positions() {
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
    fn objects_stand_in_front_of_another_robot() {
        let scene = scene("--robot test-bench --object wood").expect("a scene");
        assert_eq!(scene.objects[0].position_m, [0.3, 0.0]);
        assert_eq!(scene.grasp_hint(0).expect("a hint").from_m[..2], [0.3, 0.0]);
    }

    #[test]
    fn task_scenes_have_their_objects() {
        let names = |arguments: &str| {
            let scene = scene(arguments).expect(arguments);
            let names = scene
                .objects
                .iter()
                .map(|placed| placed.object.name.clone());
            (
                names.collect::<Vec<_>>().join(" "),
                scene.plates.len(),
                scene.sensor_rate_hz,
            )
        };
        assert_eq!(names("--scene pick-place"), ("wood".into(), 2, [1000; 2]));
        assert_eq!(
            names("--scene pick-place --object sponge"),
            ("sponge".into(), 2, [1000; 2])
        );
        assert_eq!(
            names("--scene screw --rate-hz 30"),
            ("cap open-bottle".into(), 0, [30; 2])
        );
        assert_eq!(
            names("--scene assembly --vary"),
            ("cap open-bottle".into(), 1, [1000; 2])
        );
    }

    #[test]
    fn sensor_model_sets_the_rate_unless_given() {
        let rate = |arguments: &str| {
            let scene = scene(arguments).expect(arguments);
            (scene.sensor_rate_hz[0], scene.sensor_model.about.is_empty())
        };
        assert_eq!(rate(""), (1000, true));
        assert_eq!(rate("--sensor-model design"), (1000, false));
        assert_eq!(rate("--sensor-model design --rate-hz 100"), (100, false));
    }

    #[test]
    fn usage_errors_name_the_remedy() {
        let check = |arguments: &str, part: &str| {
            let message = scene(arguments).expect_err(arguments);
            assert!(message.contains(part), "{arguments}: {message}");
        };
        check("--robot benc", "needs one of two-hand-arm");
        check(
            "--robot test-bench --hand left",
            "the robot has no left hand",
        );
        check("--robot test-bench --scene assembly", "needs both hands");
        check("--object botle", "did you mean \"bottle\"?");
        check("--object wood@here", "needs X,Y or X,Y,YAW");
        check("--object /no/such.toml", "check the path");
        check("--sensor-model desgn", "did you mean \"design\"?");
        check(
            "--sensor-model /no/such.toml",
            "could not read the sensor model",
        );
        check("--errors hysteresis=30%", "needs a number of %");
        check("--fault drop", "needs KIND[=VALUE]@START");
        check("--bus ATAS!", "use 1 to 24 characters");
        check("--duration=-1", "negative");
        check("--seed x", "invalid digit");
        check("--scene screw --object wood", "use --cap and --bottle");
        check(
            "--scene pick-place --object wood --object wood",
            "needs one --object",
        );
        check(
            "--scene pick-place --object wood@0.3,0.1",
            "has a fixed position",
        );
        check("--scene screw --cap wood", "has no thread");
        check("--scene assembly --bottle bottle", "has no neck");
        check("--cap cap", "add --scene screw or --scene assembly");
    }
}
