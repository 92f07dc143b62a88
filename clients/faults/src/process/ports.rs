//! Ports of the simulated robot on the bus.

use robot_model::HandSide;
use shm_bus::{Bus, BusError, Publisher, Subscriber};
use shm_schemas::{HandFrame, JointCommand, JointState, Status, service};
use sim_backend::{Sensed, World};

/// Sensors, joints and commands of the simulated robot, and the daemon's status.
pub(crate) struct Ports {
    frames: [Publisher<HandFrame>; 2],
    joints: Publisher<JointState>,
    commands: Subscriber<JointCommand>,
    pub(crate) command: JointCommand,
    pub(crate) statuses: Subscriber<Status>,
    pub(crate) status: Status,
    pub(crate) sensed: Sensed,
}

impl Ports {
    pub(crate) fn open(bus: &Bus) -> Result<Self, BusError> {
        let [left, right] = service::HAND_FRAME;
        Ok(Self {
            frames: [bus.publisher(left)?, bus.publisher(right)?],
            joints: bus.publisher(service::JOINT_STATE)?,
            commands: bus.subscriber(service::JOINT_COMMAND)?,
            command: JointCommand::default(),
            statuses: bus.subscriber(service::STATUS)?,
            status: Status::default(),
            sensed: Sensed::default(),
        })
    }

    /// Samples the sensors without publishing them.
    pub(crate) fn sense(&mut self, world: &mut World) {
        world.sense(&mut self.sensed);
    }

    /// Publishes the sensors of a tick. Returns the sequence number of the joint state.
    pub(crate) fn publish(&mut self, world: &mut World) -> Result<u64, BusError> {
        self.sense(world);
        for side in HandSide::BOTH {
            if let Some(frame) = &self.sensed.frames[side.index()] {
                self.frames[side.index()].send(frame)?;
            }
        }
        self.joints.send(&self.sensed.joints)?;
        Ok(self.sensed.joints.stamp.sequence)
    }

    /// Delivers the last payloads to a daemon that has joined since.
    pub(crate) fn connect_readers(&self) -> Result<(), BusError> {
        self.frames
            .iter()
            .try_for_each(Publisher::connect_readers)?;
        self.joints.connect_readers()
    }

    /// Receives commands; returns true if one answers this joint state.
    pub(crate) fn has_answer(&mut self, sequence: u64) -> Result<bool, BusError> {
        let has_come = self.commands.newest(&mut self.command)?;
        Ok(has_come && self.command.answers_sequence == sequence)
    }

    /// Returns the received commands, oldest first.
    pub(crate) fn receive(&mut self) -> Result<Vec<JointCommand>, BusError> {
        let mut commands = Vec::new();
        self.commands
            .drain(usize::MAX, |command| commands.push(*command))?;
        if let Some(newest) = commands.last() {
            self.command = *newest;
        }
        Ok(commands)
    }
}
