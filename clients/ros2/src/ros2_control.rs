//! A robot of ros2_control as the robot of the daemon.
//!
//! ```text
//!  bus ─ JointCommand ─▶ limits, validator ─▶ forward or trajectory controller
//!  /joint_states ─▶ JointState ─▶ bus
//! ```
//!
//! * **Invariants:** a command is sent only while it is valid. Without valid commands nothing is
//!   sent, and the controller holds the last position. Joint states with a missing joint or a value
//!   that is not finite are refused; the daemon then holds after `intake.hold_age_s`.

use std::time::{Duration, Instant};

use anyhow::Context as _;
use robot_model::{RobotFiles, RobotModel};
use shm_bus::{Bus, Publisher, Realtime, Subscriber, now_ns, writer_epoch};
use shm_schemas::capacity::JOINTS;
use shm_schemas::{
    Accepted, CommandValidator, JointCommand, JointSetpoints, JointState as BusJoints, Stamp,
    service,
};

use crate::arguments::{Arguments, Controller};
use crate::middleware::{Node, Publish, Quality, Subscribe};
use crate::wire::standard::{
    Duration as RosDuration, Float64Array, JointState, JointTrajectory, TrajectoryPoint,
};

/// Poll interval. Design choice: half a tick of the daemon.
const POLL: Duration = Duration::from_micros(500);
/// Interval of repeated warnings.
const WARNING: Duration = Duration::from_secs(1);
/// Tolerance of the joint limits, rad or m, for rounding errors.
const LIMIT_MARGIN_RAD: f64 = 1e-6;

/// Writer of commands.
enum Commands {
    Forward(Box<dyn Publish<Float64Array>>),
    Trajectory(Box<dyn Publish<JointTrajectory>>),
}

/// Driver of the robot.
pub(crate) struct Drive {
    names: Vec<String>,
    model: RobotModel,
    commands: Commands,
    states: Box<dyn Subscribe<JointState>>,
    interval: Duration,
}

/// State of a running drive.
struct Running {
    states: Publisher<BusJoints>,
    commands: Subscriber<JointCommand>,
    command: JointCommand,
    /// Validator from the first joint state on.
    validator: Option<CommandValidator>,
    accepted: Option<Accepted>,
    held: Vec<f64>,
    stamp: Stamp,
    warned: Option<Instant>,
}

impl Drive {
    /// Opens the topics.
    ///
    /// # Errors
    /// The robot cannot be loaded, or the middleware fails.
    pub(crate) fn open(
        node: &mut Node,
        arguments: &Arguments,
        controller: Controller,
    ) -> anyhow::Result<Self> {
        let robot = arguments.robot.as_deref().unwrap_or_default();
        let files = RobotFiles::find(robot).context("could not load the robot of --robot")?;
        let topic = arguments
            .command_topic
            .as_deref()
            .unwrap_or(controller.topic());
        Ok(Self {
            names: files.skeleton()?.joint_names().to_vec(),
            model: files.load()?,
            commands: match controller {
                Controller::Forward => Commands::Forward(node.publisher(topic, Quality::STREAM)?),
                Controller::Trajectory => {
                    Commands::Trajectory(node.publisher(topic, Quality::STREAM)?)
                }
            },
            states: node.subscription("/joint_states", Quality::NEWEST)?,
            interval: Duration::from_secs_f64(1.0 / arguments.command_rate),
        })
    }

    /// Drives the robot until `is_over`.
    ///
    /// # Errors
    /// Another process drives the robot of the bus, or the bus fails.
    pub(crate) fn run(
        &mut self,
        arguments: &Arguments,
        is_over: impl Fn() -> bool,
    ) -> anyhow::Result<()> {
        let bus = Bus::open(&arguments.bus, "atas-ros2", Realtime::No)?;
        let mut running = Running {
            states: bus.publisher(service::JOINT_STATE)?,
            commands: bus.subscriber(service::JOINT_COMMAND)?,
            command: JointCommand::default(),
            validator: None,
            accepted: None,
            held: Vec::new(),
            stamp: Stamp {
                writer_epoch: writer_epoch(),
                ..Stamp::default()
            },
            warned: None,
        };
        let mut due = Instant::now();
        while !is_over() {
            self.read_states(&mut running)?;
            self.read_commands(&mut running)?;
            if Instant::now() >= due {
                due = (due + self.interval).max(Instant::now());
                self.send_command(&running)?;
            }
            std::thread::sleep(POLL);
        }
        Ok(())
    }

    /// Passes the newest joint state on to the bus.
    fn read_states(&mut self, running: &mut Running) -> anyhow::Result<()> {
        let mut newest = None;
        loop {
            match self.states.take() {
                Ok(Some(state)) => newest = Some(state),
                Ok(None) => break,
                Err(error) => running.warn(&format!("{error:#}")),
            }
        }
        let Some(state) = newest else { return Ok(()) };
        let joints = match ordered(&state, &self.names) {
            Ok(joints) => joints,
            Err(why) => {
                running.warn(&why);
                return Ok(());
            }
        };
        if running.validator.is_none() {
            let speeds: Vec<f64> = self
                .model
                .joints()
                .map(|joint| joint.velocity_max)
                .collect();
            running.held = joints.iter().map(|[position, ..]| *position).collect();
            running.validator = Some(CommandValidator::new(&running.held, &speeds));
        }
        running.send_state(&joints)
    }

    fn read_commands(&self, running: &mut Running) -> anyhow::Result<()> {
        if !running.commands.newest(&mut running.command)? || running.command.joint_count == 0 {
            return Ok(());
        }
        let command = running.command;
        let within = self.model.joints().zip(command.position).all(|(joint, q)| {
            q >= joint.lower - LIMIT_MARGIN_RAD && q <= joint.upper + LIMIT_MARGIN_RAD
        });
        let accepted = match &mut running.validator {
            Some(validator) if within => validator.accept(&command, now_ns()),
            _ => None,
        };
        if let Some(accepted) = accepted {
            let count = self.names.len();
            running.held = accepted.setpoints.position[..count].to_vec();
            running.accepted = Some(accepted);
        }
        Ok(())
    }

    /// Sends the set-points while the last command is valid.
    fn send_command(&self, running: &Running) -> anyhow::Result<()> {
        if running.accepted.is_none() || running.command.valid_until_ns < now_ns() {
            return Ok(());
        }
        let positions = running.held.clone();
        match &self.commands {
            Commands::Forward(topic) => topic.publish(Float64Array {
                data: positions,
                ..Float64Array::default()
            }),
            Commands::Trajectory(topic) => topic.publish(JointTrajectory {
                joint_names: self.names.clone(),
                points: vec![TrajectoryPoint {
                    positions,
                    time_from_start: RosDuration {
                        sec: self.interval.as_secs() as i32,
                        nanosec: self.interval.subsec_nanos(),
                    },
                    ..TrajectoryPoint::default()
                }],
                ..JointTrajectory::default()
            }),
        }
    }
}

impl Running {
    fn warn(&mut self, why: &str) {
        if self.warned.is_none_or(|warned| warned.elapsed() > WARNING) {
            self.warned = Some(Instant::now());
            tracing::warn!("joint state refused: {why}");
        }
    }

    fn send_state(&mut self, joints: &[[f64; 3]]) -> anyhow::Result<()> {
        let count = joints.len();
        let mut state = BusJoints {
            stamp: Stamp {
                captured_ns: now_ns(),
                ..self.stamp
            },
            joint_count: count as u32,
            commanded_count: count as u32,
            commanded_position: JointSetpoints::holding(&self.held).position,
            command_epoch: self.stamp.writer_epoch,
            ..BusJoints::default()
        };
        if let Some(last) = &self.accepted {
            last.write_to(&mut state);
        }
        for (joint, [position, velocity, effort]) in joints.iter().enumerate() {
            state.position[joint] = *position;
            state.velocity[joint] = *velocity;
            state.effort[joint] = *effort;
        }
        state.seal();
        self.stamp.sequence += 1;
        Ok(self.states.send(&state)?)
    }
}

/// Returns position, velocity and effort of each joint in this order. Missing velocities and
/// efforts are zero.
fn ordered(state: &JointState, names: &[String]) -> Result<Vec<[f64; 3]>, String> {
    let given = state.name.len();
    if given > JOINTS || state.position.len() != given {
        return Err(format!(
            "it has {given} names and {} positions; give at most {JOINTS} of both",
            state.position.len()
        ));
    }
    let find = |name: &String| {
        let at = state.name.iter().position(|of| of == name);
        let at =
            at.ok_or_else(|| format!("joint {name} is missing; publish it, or check --robot"))?;
        let other = |values: &[f64]| values.get(at).copied().unwrap_or(0.0);
        let joint = [
            state.position[at],
            other(&state.velocity),
            other(&state.effort),
        ];
        // Some drivers report NaN for an effort that they do not measure.
        let joint = [
            joint[0],
            joint[1],
            if joint[2].is_nan() { 0.0 } else { joint[2] },
        ];
        match joint.iter().find(|value| !value.is_finite()) {
            Some(value) => Err(format!("joint {name} reports {value}; check its driver")),
            None => Ok(joint),
        }
    };
    names.iter().map(find).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn joints_are_ordered_by_name_and_checked() {
        let names = ["a", "b"].map(str::to_owned);
        let state = |named: &[&str], position: &[f64], effort: &[f64]| JointState {
            name: named.iter().map(|name| (*name).to_owned()).collect(),
            position: position.to_vec(),
            effort: effort.to_vec(),
            ..JointState::default()
        };
        let joints = ordered(
            &state(&["b", "x", "a"], &[1.0, 2.0, 3.0], &[f64::NAN]),
            &names,
        );
        assert_eq!(joints, Ok(vec![[3.0, 0.0, 0.0], [1.0, 0.0, 0.0]]));
        let error = |of: &JointState| ordered(of, &names).expect_err("invalid");
        assert!(error(&state(&["a"], &[1.0], &[])).contains("joint b is missing"));
        assert!(error(&state(&["a", "b"], &[1.0], &[])).contains("2 names and 1 positions"));
        assert!(error(&state(&["a", "b"], &[1.0, f64::NAN], &[])).contains("joint b reports NaN"));
    }
}
