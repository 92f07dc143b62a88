//! Bus connections of the field.

use shm_bus::{Bus, Publisher, Subscriber, now_ns, writer_epoch};
use shm_schemas::{AgentSensors, WheelCommands, service};
use sim_backend::swarm::Swarm;

use crate::failure::Failure;

pub(super) struct Ports {
    publisher: Publisher<AgentSensors>,
    subscriber: Subscriber<WheelCommands>,
    sensors: AgentSensors,
    commands: WheelCommands,
}

impl Ports {
    pub(super) fn open(bus: &Bus) -> Result<Self, Failure> {
        let mut sensors = AgentSensors::default();
        sensors.stamp.writer_epoch = writer_epoch();
        Ok(Self {
            publisher: bus.publisher(service::AGENT_SENSORS)?,
            subscriber: bus.subscriber(service::WHEEL_COMMANDS)?,
            sensors,
            commands: WheelCommands::default(),
        })
    }

    /// Publishes the robots' sensors; returns the time stamp.
    pub(super) fn publish(&mut self, swarm: &mut Swarm) -> Result<u64, Failure> {
        swarm.sense(&mut self.sensors);
        self.sensors.stamp.captured_ns = now_ns();
        self.publisher.send(&self.sensors)?;
        self.sensors.stamp.sequence += 1;
        Ok(self.sensors.stamp.captured_ns)
    }

    /// Returns the answer to the last publication if it has arrived; drops all others. The repeated
    /// time stamp also excludes answers to an earlier host.
    pub(super) fn answer(&mut self) -> Result<Option<&WheelCommands>, Failure> {
        if !self.subscriber.newest(&mut self.commands)? {
            return Ok(None);
        }
        let (asked, answered) = (&self.sensors, &self.commands);
        let fits = (asked.trial, asked.frame) == (answered.trial, answered.frame)
            && asked.stamp.captured_ns == answered.stamp.captured_ns;
        Ok(fits.then_some(&self.commands))
    }

    pub(super) fn connect_readers(&self) -> Result<(), Failure> {
        Ok(self.publisher.connect_readers()?)
    }
}
