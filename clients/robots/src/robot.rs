//! The robot as seen by the daemon: executes commands and reports joint states.
//!
//! * **Input:** port [`Report`]s and [`JointCommand`]s. **Output:** joint states and servo
//!   positions. No clock, ports or bus: time is an argument.
//! * **A joint state implies that every joint was read and holds.** While a port fails, no states
//!   are sent, and the daemon holds once the newest exceeds `intake.hold_age_s`. Commands are
//!   rejected meanwhile; working servos keep holding.
//! * **Recovery starts a new epoch:** the robot holds the servos' positions, and the daemon
//!   restarts from them. No joint jumps to its position before the failure.
//! * **Accepted commands** pass [`CommandValidator`] and all joint limits. When the last command
//!   expires, the servos keep its positions with torque.

use shm_schemas::capacity::JOINTS;
use shm_schemas::{Accepted, CommandValidator, JointCommand, JointSetpoints, JointState, Stamp};

use crate::joints::Joint;
use crate::map::JointReading;
use crate::port::Report;

/// Tolerance of the joint limits, rad or m, for rounding errors.
const LIMIT_MARGIN_RAD: f64 = 1e-6;

/// Effect of a report.
#[derive(Clone, Debug, PartialEq)]
pub enum Change {
    /// No change.
    None,
    /// All joints hold: states start.
    Ready,
    /// A port that held its servos failed, for this reason: states stop.
    Failed(String),
    /// A port could not take over its servos, for a new reason: states remain stopped.
    TakeOverFailed(String),
}

/// State of the robot.
#[derive(Debug)]
pub struct Robot {
    joints: Vec<Joint>,
    ports: Vec<PortState>,
    readings: [JointReading; JOINTS],
    held: [f64; JOINTS],
    /// Validator of commands; `None` while a port fails.
    validator: Option<CommandValidator>,
    accepted: Option<Accepted>,
    stamp: Stamp,
    draw_epoch: fn() -> u64,
    rejected: u64,
}

/// State of one port.
#[derive(Clone, Debug, Default)]
struct PortState {
    session: u32,
    /// Reason why the port does not hold; `None` before its first report.
    failure: Option<String>,
    holds: bool,
    /// Time of readings that no joint state contains yet.
    fresh_ns: Option<u64>,
}

impl Robot {
    /// Creates a robot without reports. `draw_epoch` returns new epochs.
    #[must_use]
    pub fn new(joints: Vec<Joint>, ports: usize, draw_epoch: fn() -> u64) -> Self {
        Self {
            joints,
            ports: vec![PortState::default(); ports],
            readings: [JointReading::default(); JOINTS],
            held: [0.0; JOINTS],
            validator: None,
            accepted: None,
            stamp: Stamp::default(),
            draw_epoch,
            rejected: 0,
        }
    }

    /// Processes the report of a port.
    pub fn report(&mut self, port: usize, report: Report) -> Change {
        match report {
            Report::Holding {
                session: life,
                held,
            } => {
                for (joint, position) in held {
                    self.held[joint] = position;
                }
                self.ports[port] = PortState {
                    session: life,
                    holds: true,
                    ..PortState::default()
                };
                self.start_if_ready()
            }
            Report::Read {
                captured_ns,
                joints,
            } => {
                for (joint, reading) in joints {
                    self.readings[joint] = reading;
                }
                self.ports[port].fresh_ns = Some(captured_ns);
                Change::None
            }
            Report::Failure(why) => self.stop_states(port, why),
        }
    }

    fn start_if_ready(&mut self) -> Change {
        if !self.ports.iter().all(|port| port.holds) {
            return Change::None;
        }
        let speeds: Vec<f64> = self
            .joints
            .iter()
            .map(|joint| joint.speed_max_rad_s)
            .collect();
        let held = &self.held[..self.joints.len()];
        self.validator = Some(CommandValidator::new(held, &speeds));
        self.accepted = None;
        self.stamp = Stamp {
            writer_epoch: (self.draw_epoch)(),
            ..Stamp::default()
        };
        for port in &mut self.ports {
            port.fresh_ns = None;
        }
        Change::Ready
    }

    fn stop_states(&mut self, port: usize, why: String) -> Change {
        let failed = PortState {
            failure: Some(why.clone()),
            ..PortState::default()
        };
        let before = core::mem::replace(&mut self.ports[port], failed);
        // The servos of the other ports hold the last set-points.
        self.validator = None;
        if before.holds {
            Change::Failed(why)
        } else if before.failure.as_ref() == Some(&why) {
            Change::None
        } else {
            Change::TakeOverFailed(why)
        }
    }

    /// Processes a command; returns whether it is accepted.
    pub fn command(&mut self, command: &JointCommand, now_ns: u64) -> bool {
        // Without joints, the daemon does not know the robot yet: the command is only an answer.
        if command.joint_count == 0 {
            return false;
        }
        let within = self.is_within_limits(command);
        let accepted = match &mut self.validator {
            Some(obedience) if within => obedience.accept(command, now_ns),
            _ => None,
        };
        let Some(accepted) = accepted else {
            self.rejected = self.rejected.saturating_add(1);
            return false;
        };
        self.held = accepted.setpoints.position;
        self.accepted = Some(accepted);
        true
    }

    /// Returns false for NaN.
    fn is_within_limits(&self, command: &JointCommand) -> bool {
        self.joints.iter().zip(command.position).all(|(joint, q)| {
            q >= joint.lower - LIMIT_MARGIN_RAD && q <= joint.upper + LIMIT_MARGIN_RAD
        })
    }

    /// Returns the session of a port and the set-points; `None` while a port fails or before the
    /// first accepted command.
    #[must_use]
    pub fn setpoints(&self, port: usize) -> Option<(u32, &[f64; JOINTS])> {
        self.validator.as_ref()?;
        self.accepted.as_ref()?;
        Some((self.ports[port].session, &self.held))
    }

    /// Returns a joint state if every port has new readings.
    pub fn state(&mut self) -> Option<JointState> {
        self.validator.as_ref()?;
        let fresh_ns: Option<Vec<u64>> = self.ports.iter().map(|port| port.fresh_ns).collect();
        let captured_ns = fresh_ns?.into_iter().min()?;
        for port in &mut self.ports {
            port.fresh_ns = None;
        }
        let count = self.joints.len();
        let mut state = JointState {
            stamp: Stamp {
                captured_ns,
                ..self.stamp
            },
            joint_count: count as u32,
            commanded_count: count as u32,
            commanded_position: JointSetpoints::holding(&self.held[..count]).position,
            // Before the first command, the servos hold positions of an earlier process or of the
            // take-over.
            command_epoch: self.stamp.writer_epoch,
            ..JointState::default()
        };
        if let Some(last) = &self.accepted {
            last.write_to(&mut state);
        }
        for (joint, reading) in self.readings[..count].iter().enumerate() {
            state.position[joint] = reading.position;
            state.velocity[joint] = reading.velocity;
            state.effort[joint] = reading.effort;
        }
        state.seal();
        self.stamp.sequence += 1;
        Some(state)
    }

    /// Returns the number of rejected commands.
    #[must_use]
    pub fn rejected(&self) -> u64 {
        self.rejected
    }
}
