//! Command-line arguments of a scene, and the scene built from them.

use std::str::FromStr;

use clap::{Args, ValueEnum};
use robot_model::{HandModel, HandSide, RobotModel};
use sim_backend::{Errors, GraspHint, Object, Placed, Scene, SensorModel};

use crate::failure::Failure;

#[derive(Debug, Args)]
pub(crate) struct SceneArgs {
    /// Kind of scene.
    #[arg(long, value_enum, default_value = "table")]
    scene: SceneKind,
    /// Object on the table: a built-in name or a TOML file, optionally with its position; up to
    /// four times.
    #[arg(long = "object", value_name = "NAME|FILE[@X,Y[,YAW]]  (m, m, degrees)")]
    objects: Vec<ObjectArg>,
    /// Cap to screw on: a built-in name or a TOML file with a thread [default: cap]
    #[arg(long, value_name = "NAME|FILE")]
    cap: Option<String>,
    /// Bottle of the cap: a built-in name or a TOML file with a neck [default: open-bottle]
    #[arg(long, value_name = "NAME|FILE")]
    bottle: Option<String>,
    /// Hand that objects without a position stand in front of; in assembly, the hand that screws
    /// [default: right, if present]
    #[arg(long, value_enum)]
    hand: Option<HandArg>,
    /// Randomise object properties, object poses and the height of the target, from their families.
    #[arg(long)]
    vary: bool,
    /// Errors of robot, skins, objects and client knowledge: all, or comma-separated names with
    /// amounts, see `atas-sim errors`
    #[arg(long, value_name = "NAME[=AMOUNT]", default_value = "none")]
    errors: Errors,
    /// Factor on the noise of the fingertip sensors.
    #[arg(long, default_value_t = 1.0)]
    noise: f64,
    /// Model of the fingertip sensors: a built-in name (`atas-sim sensors`) or a TOML file
    /// [default: design]
    #[arg(long, value_name = "NAME|FILE")]
    sensor_model: Option<String>,
    /// Frame rate of the fingertip sensors, 1 to 1000 Hz [default: that of the sensor model, else
    /// 1000]
    #[arg(long, value_name = "HZ")]
    rate_hz: Option<u32>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum SceneKind {
    /// Objects on the table.
    Table,
    /// One object on a plate, with a second plate as target.
    PickPlace,
    /// Cap on the neck of a clamped bottle.
    Screw,
    /// Cap on a stand, and a free bottle.
    Assembly,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum HandArg {
    Left,
    Right,
}

impl HandArg {
    fn side(self) -> HandSide {
        match self {
            Self::Left => HandSide::Left,
            Self::Right => HandSide::Right,
        }
    }
}

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
                    "position is {place:?}, needs X,Y or X,Y,YAW in metres and degrees"
                ));
            }
        };
        Ok(Self {
            name: name.into(),
            place: Some((position_m, yaw_deg.to_radians())),
        })
    }
}

impl SceneArgs {
    pub(crate) fn scene(&self, robot: &RobotModel, seed: u64) -> Result<Scene, Failure> {
        let side = self.side(robot);
        if !robot.hand(side).is_present() {
            return Err(Failure::Usage(match side {
                HandSide::Left => "the robot has no left hand; leave out --hand",
                HandSide::Right => "the robot has no right hand; leave out --hand",
            }));
        }
        let mut scene = self.nominal(robot, side)?;
        scene.noise_factor = self.noise;
        if let Some(model) = &self.sensor_model {
            scene.set_sensor_model(SensorModel::from_name_or_file(model)?);
            warn_of_other_layout(&scene.sensor_model, robot, side);
        }
        if let Some(rate_hz) = self.rate_hz {
            scene.sensor_rate_hz = [rate_hz; 2];
        }
        let scene = if self.vary { scene.varied(seed) } else { scene };
        Ok(scene.with_errors(&self.errors, seed))
    }

    fn side(&self, robot: &RobotModel) -> HandSide {
        self.hand.map_or(robot.acting_side(), HandArg::side)
    }

    /// Client command for the task of this scene, if any.
    pub(crate) fn example_command(&self, robot: &RobotModel, scene: &Scene) -> Option<String> {
        let first = scene.grasp_hint(0)?;
        let (at, yaw_deg, width_mm) = (
            format_position(&first),
            first.yaw_rad.to_degrees(),
            format_width_mm(&first),
        );
        let to = scene
            .place
            .as_ref()
            .map(format_position)
            .unwrap_or_default();
        let task = match self.scene {
            SceneKind::Table => format!("grasp --at {at} --width {width_mm}"),
            SceneKind::PickPlace => {
                let to_yaw = match scene.place {
                    Some(place) if place.yaw_rad != first.yaw_rad => {
                        format!(" --to-yaw {:.1}", place.yaw_rad.to_degrees())
                    }
                    _ => String::new(),
                };
                format!("pick-place --from {at} --to {to}{to_yaw} --width {width_mm}")
            }
            SceneKind::Screw => format!("screw --at {at} --width {width_mm}"),
            SceneKind::Assembly => {
                let bottle_mm = format_width_mm(&scene.grasp_hint(1)?);
                format!(
                    "assemble --cap {at} --cap-width {width_mm} --on {to} --bottle-width {bottle_mm}"
                )
            }
        };
        let hand = match self.side(robot) {
            HandSide::Left => " --hand left",
            HandSide::Right => "",
        };
        Some(format!("atas {task} --yaw {yaw_deg:.0}{hand}"))
    }

    fn nominal(&self, robot: &RobotModel, side: HandSide) -> Result<Scene, Failure> {
        let hand = robot.hand(side);
        let has_parts = self.cap.is_some() || self.bottle.is_some();
        match self.scene {
            SceneKind::Table | SceneKind::PickPlace if has_parts => Err(Failure::Usage(
                "--cap and --bottle need another scene; add --scene screw or --scene assembly",
            )),
            SceneKind::Screw | SceneKind::Assembly if !self.objects.is_empty() => Err(
                Failure::Usage("--object does not apply to this scene; use --cap and --bottle"),
            ),
            SceneKind::Table => self.table(hand),
            SceneKind::PickPlace => Ok(self.pick_place(side)?.moved_to_hand(hand)),
            SceneKind::Screw => {
                Ok(Scene::screw(self.cap()?, self.bottle()?, side).moved_to_hand(hand))
            }
            SceneKind::Assembly if robot.sides().count() < 2 => Err(Failure::Usage(
                "assembly needs both hands; choose a robot with two hands",
            )),
            SceneKind::Assembly => {
                Ok(Scene::assembly(self.cap()?, self.bottle()?, side).moved_to_hand(hand))
            }
        }
    }

    fn table(&self, hand: &HandModel) -> Result<Scene, Failure> {
        let mut scene = Scene::default();
        let yaw_rad = hand.home_yaw_rad();
        for ObjectArg { name, place } in &self.objects {
            let object = Object::from_name_or_file(name)?;
            scene.objects.push(match *place {
                Some((position_m, yaw_rad)) => Placed::new(object, position_m, yaw_rad),
                None => Placed::new(object, hand.object_m(), yaw_rad),
            });
        }
        Ok(scene)
    }

    fn pick_place(&self, side: HandSide) -> Result<Scene, Failure> {
        let name = match &self.objects[..] {
            [] => Scene::OBJECT,
            [ObjectArg { name, place: None }] => name,
            [_] => {
                return Err(Failure::Usage(
                    "the object of pick-place has a fixed position; leave out @X,Y",
                ));
            }
            _ => {
                return Err(Failure::Usage(
                    "pick-place needs one --object; leave out the others",
                ));
            }
        };
        Ok(Scene::pick_place(Object::from_name_or_file(name)?, side))
    }

    fn cap(&self) -> Result<Object, Failure> {
        let cap = Object::from_name_or_file(self.cap.as_deref().unwrap_or(Scene::CAP))?;
        match cap.thread {
            Some(_) => Ok(cap),
            None => Err(Failure::Usage(
                "the cap has no thread; choose one with a thread with --cap",
            )),
        }
    }

    fn bottle(&self) -> Result<Object, Failure> {
        let bottle = Object::from_name_or_file(self.bottle.as_deref().unwrap_or(Scene::BOTTLE))?;
        match bottle.neck {
            Some(_) => Ok(bottle),
            None => Err(Failure::Usage(
                "the bottle has no neck; choose one with a neck with --bottle",
            )),
        }
    }
}

/// Logs a warning if the values of a model describe elements of another layout.
fn warn_of_other_layout(model: &SensorModel, robot: &RobotModel, side: HandSide) {
    let skin = robot.hand(side).skin().layout.to_string();
    if let Some(layout) = model.layout.as_ref().filter(|layout| **layout != skin) {
        tracing::warn!(
            layout,
            skin,
            "the sensor model describes elements of another layout; its values apply to each \
             element of this skin"
        );
    }
}

/// Position as a command-line argument.
fn format_position(hint: &GraspHint) -> String {
    let [x, y, z] = hint.from_m;
    format!("{x:.3},{y:.3},{z:.4}")
}

/// Width, mm.
fn format_width_mm(hint: &GraspHint) -> String {
    format!("{:.1}", hint.width_m * 1e3)
}
