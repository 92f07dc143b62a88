//! What a goal may be told.

use std::time::Duration;

use atas_client::goal;
use atas_client::scenes::Usual;
use clap::{Args, ValueEnum};
use shm_schemas::{Hand, Turn};

use super::BusArgument;
use super::values::{Place, duration, finite, place, position_m, task_name};

/// Usual lift as users type it, mm.
const LIFT_MM: f64 = goal::LIFT_M * 1e3;

/// `atas grasp`.
#[derive(Args, Clone, Debug)]
pub struct Grasp {
    /// Where the fingertips shall close, metres from the robot's base: x forward, y left, z up
    #[arg(long, visible_alias = "from", value_name = "X,Y,Z", value_parser = position_m, allow_hyphen_values = true)]
    pub at: [f64; 3],
    /// Direction of the closing axis, degrees from x towards y
    #[arg(long, value_name = "DEG", default_value_t = 90.0, value_parser = finite, allow_hyphen_values = true)]
    pub yaw: f64,
    /// Expected width of the object along the closing axis, millimetres
    #[arg(long, value_name = "MM", value_parser = finite, allow_hyphen_values = true)]
    pub width: f64,
    /// How far to lift, millimetres
    #[arg(long, value_name = "MM", default_value_t = LIFT_MM, value_parser = finite, allow_hyphen_values = true)]
    pub lift: f64,
    /// What else is known of the object
    #[command(flatten)]
    pub known: Known,
    /// How long to hold before the goal counts as reached, seconds
    #[arg(long, value_name = "S", default_value_t = goal::HOLD_S, value_parser = finite, allow_hyphen_values = true)]
    pub hold: f64,
    /// How the goal is sent
    #[command(flatten)]
    pub sending: Sending,
}

/// `atas pick-place`.
#[derive(Args, Clone, Debug)]
#[command(after_help = Usual::PickPlace.help())]
pub struct PickPlace {
    /// Where the fingertips shall close, metres from the robot's base: x forward, y left, z up
    #[arg(long, visible_alias = "at", value_name = "X,Y[,Z]", value_parser = place, allow_hyphen_values = true)]
    pub from: Option<Place>,
    /// Where they shall let go. Without Z as high as they closed
    #[arg(long, value_name = "X,Y[,Z]", value_parser = place, allow_hyphen_values = true)]
    pub to: Option<Place>,
    /// Direction of the closing axis, degrees from x towards y
    #[arg(long, value_name = "DEG", value_parser = finite, allow_hyphen_values = true)]
    pub yaw: Option<f64>,
    /// Its direction where they let go [default: as before]
    #[arg(long, value_name = "DEG", value_parser = finite, allow_hyphen_values = true)]
    pub to_yaw: Option<f64>,
    /// Expected width of the object along the closing axis, millimetres
    #[arg(long, value_name = "MM", value_parser = finite, allow_hyphen_values = true)]
    pub width: Option<f64>,
    /// How far to lift over the higher of both places, millimetres
    #[arg(long, value_name = "MM", default_value_t = LIFT_MM, value_parser = finite, allow_hyphen_values = true)]
    pub lift: f64,
    /// What else is known of the object
    #[command(flatten)]
    pub known: Known,
    /// How the goal is sent
    #[command(flatten)]
    pub sending: Sending,
}

/// `atas screw`.
#[derive(Args, Clone, Debug)]
#[command(after_help = Usual::Screw.help())]
pub struct Screw {
    /// Where the fingertips shall close on the cap, metres from the robot's base: x forward, y left, z up
    #[arg(long, visible_alias = "from", value_name = "X,Y[,Z]", value_parser = place, allow_hyphen_values = true)]
    pub at: Option<Place>,
    /// Direction of the closing axis, degrees from x towards y
    #[arg(long, value_name = "DEG", value_parser = finite, allow_hyphen_values = true)]
    pub yaw: Option<f64>,
    /// Diameter of the cap, millimetres
    #[arg(long, value_name = "MM", value_parser = finite, allow_hyphen_values = true)]
    pub width: Option<f64>,
    /// Which way to turn, seen from above
    #[arg(long, value_enum, default_value_t = TurnName::Clockwise)]
    pub turn: TurnName,
    /// How the goal is sent
    #[command(flatten)]
    pub sending: Sending,
}

/// `atas assemble`.
#[derive(Args, Clone, Debug)]
#[command(after_help = Usual::Assembly.help())]
pub struct Assemble {
    /// Where the fingertips shall close on the cap, metres from the robot's base: x forward, y left, z up
    #[arg(long, visible_aliases = ["at", "from"], value_name = "X,Y[,Z]", value_parser = place, allow_hyphen_values = true)]
    pub cap: Option<Place>,
    /// Diameter of the cap, millimetres
    #[arg(long, value_name = "MM", value_parser = finite, allow_hyphen_values = true)]
    pub cap_width: Option<f64>,
    /// Where the fingertips shall be when the cap sits on the bottle; the other hand holds the bottle below
    #[arg(long, visible_alias = "to", value_name = "X,Y[,Z]", value_parser = place, allow_hyphen_values = true)]
    pub on: Option<Place>,
    /// Diameter of the bottle, millimetres
    #[arg(long, value_name = "MM", value_parser = finite, allow_hyphen_values = true)]
    pub bottle_width: Option<f64>,
    /// Direction of the closing axis on the cap, degrees from x towards y
    #[arg(long, value_name = "DEG", value_parser = finite, allow_hyphen_values = true)]
    pub yaw: Option<f64>,
    /// Which way to turn, seen from above
    #[arg(long, value_enum, default_value_t = TurnName::Clockwise)]
    pub turn: TurnName,
    /// How the goal is sent
    #[command(flatten)]
    pub sending: Sending,
}

/// `atas task`.
#[derive(Args, Clone, Debug)]
#[command(after_help = Usual::PickPlace.help())]
pub struct UserTask {
    /// Its name in the daemon's configuration
    #[arg(value_parser = task_name)]
    pub name: String,
    /// Where the fingertips shall close, metres from the robot's base: x forward, y left, z up
    #[arg(long, visible_alias = "at", value_name = "X,Y[,Z]", value_parser = place, allow_hyphen_values = true)]
    pub from: Option<Place>,
    /// Where a task that conveys takes the object. Without Z as high as it was
    #[arg(long, value_name = "X,Y[,Z]", value_parser = place, allow_hyphen_values = true)]
    pub to: Option<Place>,
    /// Direction of the closing axis, degrees from x towards y
    #[arg(long, value_name = "DEG", value_parser = finite, allow_hyphen_values = true)]
    pub yaw: Option<f64>,
    /// Its direction at the other place [default: as before]
    #[arg(long, value_name = "DEG", value_parser = finite, allow_hyphen_values = true)]
    pub to_yaw: Option<f64>,
    /// Expected width of the object along the closing axis, millimetres
    #[arg(long, value_name = "MM", value_parser = finite, allow_hyphen_values = true)]
    pub width: Option<f64>,
    /// Expected width of what the other hand holds in a task for both hands, millimetres
    #[arg(long, value_name = "MM", default_value_t = 0.0, value_parser = finite, allow_hyphen_values = true)]
    pub helper_width: f64,
    /// What else is known of the object
    #[command(flatten)]
    pub known: Known,
    /// How far a task that lifts lifts, millimetres
    #[arg(long, value_name = "MM", default_value_t = LIFT_MM, value_parser = finite, allow_hyphen_values = true)]
    pub lift: f64,
    /// How long a task that holds holds, seconds
    #[arg(long, value_name = "S", default_value_t = goal::HOLD_S, value_parser = finite, allow_hyphen_values = true)]
    pub hold: f64,
    /// Which way a task that turns turns, seen from above
    #[arg(long, value_enum, default_value_t = TurnName::Clockwise)]
    pub turn: TurnName,
    /// How the goal is sent
    #[command(flatten)]
    pub sending: Sending,
}

/// `atas release`.
#[derive(Args, Clone, Debug)]
pub struct Release {
    /// How the goal is sent
    #[command(flatten)]
    pub sending: Sending,
}

/// `atas zero`.
#[derive(Args, Clone, Debug)]
pub struct Zero {
    /// Which hand; it must be empty, and the daemon ready
    #[arg(long, value_enum, default_value_t = HandName::Right)]
    pub hand: HandName,
    /// Which bus
    #[command(flatten)]
    pub bus: BusArgument,
}

/// What a user may know of an object beside its place and width.
#[derive(Args, Clone, Debug)]
pub struct Known {
    /// How far the object reaches above where the fingertips close, millimetres: the hand comes from above that [default:
    /// not known, taken for less than `motion.descend_m`]
    #[arg(long, value_name = "MM", value_parser = finite, allow_hyphen_values = true)]
    pub top: Option<f64>,
    /// What the object may be pressed with at most, newtons: F_2 [default: what its stiffness allows]
    #[arg(long, value_name = "N", value_parser = finite, allow_hyphen_values = true)]
    pub max_force: Option<f64>,
}

/// How a goal is sent and followed.
#[derive(Args, Clone, Debug)]
pub struct Sending {
    /// Which hand; in an assembly the one that screws
    #[arg(long, value_enum, default_value_t = HandName::Right)]
    pub hand: HandName,
    /// Hold the robot if this command dies; without it the goal then goes on to its end
    #[arg(long)]
    pub attached: bool,
    /// Cancel the goal if it takes longer, seconds
    #[arg(long, value_name = "S", value_parser = duration)]
    pub timeout: Option<Duration>,
    /// Which daemon
    #[command(flatten)]
    pub bus: BusArgument,
}

/// A hand, as users name it.
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

/// A sense of turning, as users name it.
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
