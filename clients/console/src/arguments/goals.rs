//! Arguments of the commands that send a goal, and of `atas zero`.

use std::time::Duration;

use atas_client::goal;
use atas_client::scenes::DefaultScene;
use clap::{Args, ValueEnum};
use shm_schemas::{Hand, Turn};

use super::BusArgument;
use super::values::{Place, duration, finite, place, position_m, task_name, width_mm};

/// Default lift height, mm.
const LIFT_MM: f64 = goal::LIFT_M * 1e3;

/// `atas grasp`.
#[derive(Args, Clone, Debug)]
pub struct Grasp {
    /// Grasp position, metres in the base frame: x forward, y left, z up
    #[arg(long, visible_alias = "from", value_name = "X,Y,Z", value_parser = position_m, allow_hyphen_values = true)]
    pub at: [f64; 3],
    /// Direction of the closing axis, degrees from x towards y
    #[arg(long, value_name = "DEG", default_value_t = 90.0, value_parser = finite, allow_hyphen_values = true)]
    pub yaw: f64,
    /// Expected width of the object along the closing axis, millimetres
    #[arg(long, value_name = "MM", value_parser = width_mm, allow_hyphen_values = true)]
    pub width: f64,
    /// Lift height, millimetres
    #[arg(long, value_name = "MM", default_value_t = LIFT_MM, value_parser = finite, allow_hyphen_values = true)]
    pub lift: f64,
    /// Further known properties of the object
    #[command(flatten)]
    pub known: ObjectProperties,
    /// Hold time before the goal succeeds, seconds
    #[arg(long, value_name = "S", default_value_t = goal::HOLD_S, value_parser = finite, allow_hyphen_values = true)]
    pub hold: f64,
    /// Options for sending the goal
    #[command(flatten)]
    pub sending: SendOptions,
}

/// `atas pick-place`.
#[derive(Args, Clone, Debug)]
#[command(after_help = DefaultScene::PickPlace.help())]
pub struct PickPlace {
    /// Grasp position, metres in the base frame: x forward, y left, z up
    #[arg(long, visible_alias = "at", value_name = "X,Y[,Z]", value_parser = place, allow_hyphen_values = true)]
    pub from: Option<Place>,
    /// Release position; without Z at the grasp height
    #[arg(long, value_name = "X,Y[,Z]", value_parser = place, allow_hyphen_values = true)]
    pub to: Option<Place>,
    /// Direction of the closing axis, degrees from x towards y
    #[arg(long, value_name = "DEG", value_parser = finite, allow_hyphen_values = true)]
    pub yaw: Option<f64>,
    /// Direction of the closing axis at release [default: as at the grasp]
    #[arg(long, value_name = "DEG", value_parser = finite, allow_hyphen_values = true)]
    pub to_yaw: Option<f64>,
    /// Expected width of the object along the closing axis, millimetres
    #[arg(long, value_name = "MM", value_parser = width_mm, allow_hyphen_values = true)]
    pub width: Option<f64>,
    /// Lift height above the higher of both places, millimetres
    #[arg(long, value_name = "MM", default_value_t = LIFT_MM, value_parser = finite, allow_hyphen_values = true)]
    pub lift: f64,
    /// Further known properties of the object
    #[command(flatten)]
    pub known: ObjectProperties,
    /// Options for sending the goal
    #[command(flatten)]
    pub sending: SendOptions,
}

/// `atas screw`.
#[derive(Args, Clone, Debug)]
#[command(after_help = DefaultScene::Screw.help())]
pub struct Screw {
    /// Grasp position on the cap, metres in the base frame: x forward, y left, z up
    #[arg(long, visible_alias = "from", value_name = "X,Y[,Z]", value_parser = place, allow_hyphen_values = true)]
    pub at: Option<Place>,
    /// Direction of the closing axis, degrees from x towards y
    #[arg(long, value_name = "DEG", value_parser = finite, allow_hyphen_values = true)]
    pub yaw: Option<f64>,
    /// Diameter of the cap, millimetres
    #[arg(long, value_name = "MM", value_parser = width_mm, allow_hyphen_values = true)]
    pub width: Option<f64>,
    /// Sense of rotation, seen from above
    #[arg(long, value_enum, default_value_t = TurnName::Clockwise)]
    pub turn: TurnName,
    /// Options for sending the goal
    #[command(flatten)]
    pub sending: SendOptions,
}

/// `atas assemble`.
#[derive(Args, Clone, Debug)]
#[command(after_help = DefaultScene::Assembly.help())]
pub struct Assemble {
    /// Grasp position on the cap, metres in the base frame: x forward, y left, z up
    #[arg(long, visible_aliases = ["at", "from"], value_name = "X,Y[,Z]", value_parser = place, allow_hyphen_values = true)]
    pub cap: Option<Place>,
    /// Diameter of the cap, millimetres
    #[arg(long, value_name = "MM", value_parser = width_mm, allow_hyphen_values = true)]
    pub cap_width: Option<f64>,
    /// Position of the fingertips when the cap sits on the bottle
    ///
    /// The other hand holds the bottle below.
    #[arg(long, visible_alias = "to", value_name = "X,Y[,Z]", value_parser = place, allow_hyphen_values = true)]
    pub on: Option<Place>,
    /// Diameter of the bottle, millimetres
    #[arg(long, value_name = "MM", value_parser = width_mm, allow_hyphen_values = true)]
    pub bottle_width: Option<f64>,
    /// Direction of the closing axis on the cap, degrees from x towards y
    #[arg(long, value_name = "DEG", value_parser = finite, allow_hyphen_values = true)]
    pub yaw: Option<f64>,
    /// Sense of rotation, seen from above
    #[arg(long, value_enum, default_value_t = TurnName::Clockwise)]
    pub turn: TurnName,
    /// Options for sending the goal
    #[command(flatten)]
    pub sending: SendOptions,
}

/// `atas task`.
#[derive(Args, Clone, Debug)]
#[command(after_help = DefaultScene::PickPlace.help())]
pub struct UserTask {
    /// Task name in the daemon's configuration
    #[arg(value_parser = task_name)]
    pub name: String,
    /// Grasp position, metres in the base frame: x forward, y left, z up
    #[arg(long, visible_alias = "at", value_name = "X,Y[,Z]", value_parser = place, allow_hyphen_values = true)]
    pub from: Option<Place>,
    /// Target position of tasks that carry; without Z at the grasp height
    #[arg(long, value_name = "X,Y[,Z]", value_parser = place, allow_hyphen_values = true)]
    pub to: Option<Place>,
    /// Direction of the closing axis, degrees from x towards y
    #[arg(long, value_name = "DEG", value_parser = finite, allow_hyphen_values = true)]
    pub yaw: Option<f64>,
    /// Direction of the closing axis at the target [default: as at the grasp]
    #[arg(long, value_name = "DEG", value_parser = finite, allow_hyphen_values = true)]
    pub to_yaw: Option<f64>,
    /// Expected width of the object along the closing axis, millimetres
    #[arg(long, value_name = "MM", value_parser = width_mm, allow_hyphen_values = true)]
    pub width: Option<f64>,
    /// Expected width of the other hand's object in two-hand tasks, millimetres
    #[arg(long, value_name = "MM", default_value_t = 0.0, value_parser = width_mm, allow_hyphen_values = true)]
    pub helper_width: f64,
    /// Further known properties of the object
    #[command(flatten)]
    pub known: ObjectProperties,
    /// Lift height of tasks that lift, millimetres
    #[arg(long, value_name = "MM", default_value_t = LIFT_MM, value_parser = finite, allow_hyphen_values = true)]
    pub lift: f64,
    /// Hold time of tasks that hold, seconds
    #[arg(long, value_name = "S", default_value_t = goal::HOLD_S, value_parser = finite, allow_hyphen_values = true)]
    pub hold: f64,
    /// Sense of rotation of tasks that turn, seen from above
    #[arg(long, value_enum, default_value_t = TurnName::Clockwise)]
    pub turn: TurnName,
    /// Options for sending the goal
    #[command(flatten)]
    pub sending: SendOptions,
}

/// `atas release`.
#[derive(Args, Clone, Debug)]
pub struct Release {
    /// Options for sending the goal
    #[command(flatten)]
    pub sending: SendOptions,
}

/// `atas zero`.
#[derive(Args, Clone, Debug)]
pub struct Zero {
    /// Hand to zero; it must be empty and the daemon ready
    #[arg(long, value_enum, default_value_t = HandName::Right)]
    pub hand: HandName,
    /// Daemon of the hand
    #[command(flatten)]
    pub bus: BusArgument,
}

/// Optional properties of an object, in addition to position and width.
#[derive(Args, Clone, Debug)]
pub struct ObjectProperties {
    /// Height of the object above the grasp position, millimetres
    ///
    /// The hand approaches from above this height [default: unknown, assumed below
    /// `motion.descend_m`]
    #[arg(long, value_name = "MM", value_parser = finite, allow_hyphen_values = true)]
    pub top: Option<f64>,
    /// Force limit F_2 of the object, newtons [default: from its stiffness]
    #[arg(long, value_name = "N", value_parser = finite, allow_hyphen_values = true)]
    pub max_force: Option<f64>,
}

/// Options of a command that sends a goal and waits for its end.
#[derive(Args, Clone, Debug)]
pub struct SendOptions {
    /// Hand; in an assembly the hand that screws
    #[arg(long, value_enum, default_value_t = HandName::Right)]
    pub hand: HandName,
    /// Hold the robot if this command dies; otherwise the goal continues
    #[arg(long)]
    pub attached: bool,
    /// Cancel the goal after this time, seconds
    #[arg(long, value_name = "S", value_parser = duration)]
    pub timeout: Option<Duration>,
    /// Daemon that runs the goal
    #[command(flatten)]
    pub bus: BusArgument,
}

/// Hand on the command line.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum HandName {
    /// The left hand
    Left,
    /// The right hand
    Right,
}

impl From<HandName> for Hand {
    fn from(name: HandName) -> Self {
        match name {
            HandName::Left => Self::LEFT,
            HandName::Right => Self::RIGHT,
        }
    }
}

/// Sense of rotation on the command line.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum TurnName {
    /// Closes an ordinary thread
    Clockwise,
    /// Closes a left-hand thread
    Anticlockwise,
}

impl From<TurnName> for Turn {
    fn from(name: TurnName) -> Self {
        match name {
            TurnName::Clockwise => Self::CLOCKWISE,
            TurnName::Anticlockwise => Self::ANTICLOCKWISE,
        }
    }
}
