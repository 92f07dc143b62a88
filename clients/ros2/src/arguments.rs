//! Command line.

use clap::{Parser, ValueEnum};
use shm_bus::BusName;
use shm_schemas::Hand;

use crate::middleware::{Middleware, NodeOptions, ServiceMapping};

/// Largest domain of ROS 2 whose ports lie below those of outgoing connections on Linux.
const DOMAIN_MAX: i64 = 101;
/// Range of publishing rates, Hz. Design choice: from a slow plot to every fifth tick.
const RATES_HZ: std::ops::RangeInclusive<f64> = 0.1..=200.0;

/// Bridge between a running daemon and ROS 2: topics, actions, services and parameters
#[derive(Clone, Debug, Parser)]
#[command(version, long_version = shm_bus::long_version(), after_help = EXAMPLES)]
pub struct Arguments {
    /// Bus of the daemon
    #[arg(long, value_name = "NAME", env = BusName::ENV, default_value_t)]
    pub bus: BusName,
    /// Middleware of the peers
    #[arg(long, value_enum, default_value_t = default_middleware())]
    pub middleware: Middleware,
    /// Mapping of services to DDS: that of the peers' rmw implementation
    #[arg(long, value_enum, default_value_t = ServiceMapping::Fastdds)]
    pub services: ServiceMapping,
    /// ROS domain
    #[arg(long, env = "ROS_DOMAIN_ID", default_value_t = 0,
          value_parser = clap::value_parser!(u16).range(0..=DOMAIN_MAX))]
    pub domain: u16,
    /// Namespace of the node and of its own topics, actions and services
    #[arg(long, default_value = "/atas", value_parser = namespace)]
    pub namespace: String,
    /// Zenoh only: address of the router
    #[arg(long, default_value = "tcp/127.0.0.1:7447")]
    pub router: String,
    /// Rate of joint states, Hz
    #[arg(long, value_name = "HZ", default_value_t = 100.0, value_parser = rate)]
    pub joint_rate: f64,
    /// Rate of transforms, wrenches and hand states, Hz; at most the daemon's view rate, 60 Hz
    #[arg(long, value_name = "HZ", default_value_t = 50.0, value_parser = rate)]
    pub state_rate: f64,
    /// Rate of point clouds, Hz
    #[arg(long, value_name = "HZ", default_value_t = 30.0, value_parser = rate)]
    pub cloud_rate: f64,
    /// ros2_control, daemon as hardware: follow the joint commands in NAMESPACE/joint_commands with
    /// this hand
    #[arg(long, value_name = "HAND", value_enum)]
    pub follow: Option<Side>,
    /// ros2_control, their robot as the daemon's robot: send joint commands to this kind of
    /// controller, and read /joint_states
    #[arg(long, value_name = "CONTROLLER", value_enum, requires = "robot")]
    pub drive: Option<Controller>,
    /// With --drive: robot of the daemon, a shipped name or a file
    #[arg(long, value_name = "NAME|FILE", requires = "drive")]
    pub robot: Option<String>,
    /// With --drive: topic of the controller's commands
    #[arg(long, value_name = "TOPIC", requires = "drive")]
    pub command_topic: Option<String>,
    /// With --drive: rate of commands, Hz
    #[arg(long, value_name = "HZ", default_value_t = 100.0, value_parser = rate)]
    pub command_rate: f64,
    /// Prints every interface with its type hash, and exits
    #[arg(long)]
    pub print_types: bool,
}

/// Hand.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Side {
    /// Left hand
    Left,
    /// Right hand
    Right,
}

impl From<Side> for Hand {
    fn from(side: Side) -> Self {
        match side {
            Side::Left => Self::LEFT,
            Side::Right => Self::RIGHT,
        }
    }
}

/// Kind of a controller of ros2_control.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Controller {
    /// forward_command_controller: std_msgs/Float64MultiArray
    Forward,
    /// joint_trajectory_controller: trajectory_msgs/JointTrajectory
    Trajectory,
}

impl Controller {
    /// Returns the topic of a controller with its usual name.
    #[must_use]
    pub fn topic(self) -> &'static str {
        match self {
            Self::Forward => "/forward_position_controller/commands",
            Self::Trajectory => "/joint_trajectory_controller/joint_trajectory",
        }
    }
}

const EXAMPLES: &str = "Examples:
  atas-ros2
  atas-ros2 --domain 7 --services cyclonedds
  atas-ros2 --middleware zenoh --router tcp/10.0.0.2:7447
  atas-ros2 --drive forward --robot my_arm.toml";

fn default_middleware() -> Middleware {
    if cfg!(feature = "dds") {
        Middleware::Dds
    } else {
        Middleware::Zenoh
    }
}

fn rate(text: &str) -> Result<f64, String> {
    let hz: f64 = text.parse().map_err(|_| format!("{text:?} is no number"))?;
    if RATES_HZ.contains(&hz) {
        Ok(hz)
    } else {
        Err(format!(
            "{hz} Hz is outside {} to {} Hz",
            RATES_HZ.start(),
            RATES_HZ.end()
        ))
    }
}

fn namespace(text: &str) -> Result<String, String> {
    let is_word = |word: &str| {
        let mut letters = word.chars();
        letters
            .next()
            .is_some_and(|c| c.is_ascii_alphabetic() || c == '_')
            && letters.all(|c| c.is_ascii_alphanumeric() || c == '_')
    };
    match text.strip_prefix('/') {
        Some(words) if words.split('/').all(is_word) => Ok(text.to_owned()),
        _ => Err(format!(
            "{text:?} is no namespace; it needs a slash, then a letter, then letters, digits and \
             underscores, for example /atas"
        )),
    }
}

impl Arguments {
    /// Returns the address of the node.
    #[must_use]
    pub fn node(&self) -> NodeOptions {
        NodeOptions {
            middleware: self.middleware,
            domain: self.domain,
            namespace: self.namespace.clone(),
            name: "bridge".to_owned(),
            services: self.services,
            router: self.router.clone(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arguments_out_of_range_are_rejected() {
        let parse = |line: &str| Arguments::try_parse_from(line.split(' '));
        let hz = parse("atas-ros2 --joint-rate 50")
            .expect("valid")
            .joint_rate;
        assert!((hz - 50.0).abs() < f64::EPSILON);
        for wrong in [
            "--joint-rate 1000",
            "--joint-rate nan",
            "--domain 102",
            "--namespace atas",
            "--namespace /a-b",
            "--namespace /",
            "--services connext",
        ] {
            assert!(parse(&format!("atas-ros2 {wrong}")).is_err(), "{wrong}");
        }
    }
}
