//! The robot as the daemon sees it: commands in, joint states out, whatever its ports are doing.
//!
//! * **In:** [`Report`]s of the ports and [`JointCommand`]s. **Out:** joint states, and the positions that the servos shall hold. No
//!   clock, no port, no bus: time is an argument.
//! * **A joint state says that every joint was read and holds.** While one is in doubt there are none: the daemon holds when the
//!   newest is older than `intake.hold_age_s`. Commands move nothing meanwhile; every servo that can goes on holding.
//! * **After trouble it is another robot:** its states have a new epoch, it holds what its servos hold, and obeys from there. The daemon
//!   then begins anew from what is told, so that nothing jumps to where a servo was before it lost its power.
//! * **Obeyed** is what [`Obedience`] lets pass and what lies within every joint's limits. On expiry the last positions stay, with
//!   torque; that needs nobody to do anything.

use shm_schemas::capacity::JOINTS;
use shm_schemas::{Accepted, JointCommand, JointState, Obedience, Orders, Stamp};

use crate::joints::Joint;
use crate::map::JointReading;
use crate::port::Report;

/// How far outside its limits a command may order a joint, rad: rounding.
const LIMIT_MARGIN_RAD: f64 = 1e-6;

/// What became of a report.
#[derive(Clone, Debug, PartialEq)]
pub enum Change {
    /// Nothing new.
    None,
    /// From now on all joints hold: states begin.
    Whole,
    /// From now on there are no states, for this reason.
    Broken(String),
    /// Another reason than before why there are none.
    StillBroken(String),
}

/// The robot.
#[derive(Debug)]
pub struct Robot {
    joints: Vec<Joint>,
    ports: Vec<PortState>,
    readings: [JointReading; JOINTS],
    held_rad: [f64; JOINTS],
    /// Who judges commands; nobody while a joint is in doubt.
    obedience: Option<Obedience>,
    obeyed: Option<Accepted>,
    stamp: Stamp,
    draw_epoch: fn() -> u64,
    refused: u64,
}

/// What is known of one port.
#[derive(Clone, Debug, Default)]
struct PortState {
    life: u32,
    /// Why it does not hold; at first because nothing was heard of it.
    trouble: Option<String>,
    holds: bool,
    /// When its readings that nobody was told of yet were taken.
    fresh_ns: Option<u64>,
}

impl Robot {
    /// A robot of so many ports, of which nothing is known. Epochs are drawn from `draw_epoch`.
    #[must_use]
    pub fn new(joints: Vec<Joint>, ports: usize, draw_epoch: fn() -> u64) -> Self {
        Self {
            joints,
            ports: vec![PortState::default(); ports],
            readings: [JointReading::default(); JOINTS],
            held_rad: [0.0; JOINTS],
            obedience: None,
            obeyed: None,
            stamp: Stamp::default(),
            draw_epoch,
            refused: 0,
        }
    }

    /// Takes in what a port reports.
    pub fn report(&mut self, port: usize, report: Report) -> Change {
        match report {
            Report::Holding { life, held_rad } => {
                for (joint, position_rad) in held_rad {
                    self.held_rad[joint] = position_rad;
                }
                self.ports[port] = PortState {
                    life,
                    holds: true,
                    ..PortState::default()
                };
                self.begin_if_whole()
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
            Report::Trouble(why) => self.break_off(port, why),
        }
    }

    fn begin_if_whole(&mut self) -> Change {
        if !self.ports.iter().all(|port| port.holds) {
            return Change::None;
        }
        let speeds: Vec<f64> = self
            .joints
            .iter()
            .map(|joint| joint.speed_max_rad_s)
            .collect();
        let held_rad = &self.held_rad[..self.joints.len()];
        self.obedience = Some(Obedience::at(held_rad, &speeds));
        self.obeyed = None;
        self.stamp = Stamp {
            writer_epoch: (self.draw_epoch)(),
            ..Stamp::default()
        };
        for port in &mut self.ports {
            port.fresh_ns = None;
        }
        Change::Whole
    }

    fn break_off(&mut self, port: usize, why: String) -> Change {
        let known = self.ports[port].trouble.as_ref() == Some(&why);
        self.ports[port] = PortState {
            trouble: Some(why.clone()),
            ..PortState::default()
        };
        if self.obedience.take().is_some() {
            // What was ordered last is what the servos of the other ports hold.
            return Change::Broken(why);
        }
        if known {
            Change::None
        } else {
            Change::StillBroken(why)
        }
    }

    /// Takes in a command; whether it is obeyed.
    pub fn command(&mut self, command: &JointCommand, now_ns: u64) -> bool {
        // Before the daemon knows the joints its commands are for none: they answer, and move nothing.
        if command.joint_count == 0 {
            return false;
        }
        let within = self.is_within_limits(command);
        let accepted = match &mut self.obedience {
            Some(obedience) if within => obedience.accept(command, now_ns),
            _ => None,
        };
        let Some(accepted) = accepted else {
            self.refused = self.refused.saturating_add(1);
            return false;
        };
        self.held_rad = accepted.orders.position_rad;
        self.obeyed = Some(accepted);
        true
    }

    /// False for NaN.
    fn is_within_limits(&self, command: &JointCommand) -> bool {
        self.joints
            .iter()
            .zip(command.position_rad)
            .all(|(joint, q_rad)| {
                q_rad >= joint.lower_rad - LIMIT_MARGIN_RAD
                    && q_rad <= joint.upper_rad + LIMIT_MARGIN_RAD
            })
    }

    /// What a port shall hold, and in which of its lives; nothing while a joint is in doubt, or before a command was obeyed.
    #[must_use]
    pub fn orders(&self, port: usize) -> Option<(u32, &[f64; JOINTS])> {
        self.obedience.as_ref()?;
        self.obeyed.as_ref()?;
        Some((self.ports[port].life, &self.held_rad))
    }

    /// A joint state, if every port has read its joints since the last one.
    pub fn state(&mut self) -> Option<JointState> {
        self.obedience.as_ref()?;
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
            commanded_rad: Orders::holding(&self.held_rad[..count]).position_rad,
            // Until a command is obeyed, the servos hold what an earlier process, or a taking over, told them.
            command_epoch: self.stamp.writer_epoch,
            ..JointState::default()
        };
        if let Some(last) = &self.obeyed {
            last.tell(&mut state);
        }
        for (joint, reading) in self.readings[..count].iter().enumerate() {
            state.position_rad[joint] = reading.position_rad;
            state.velocity_rad_s[joint] = reading.velocity_rad_s;
            state.effort_n_m[joint] = reading.effort_n_m;
        }
        state.seal();
        self.stamp.sequence += 1;
        Some(state)
    }

    /// Commands that were refused.
    #[must_use]
    pub fn refused(&self) -> u64 {
        self.refused
    }
}
