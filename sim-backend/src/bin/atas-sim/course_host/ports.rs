//! Bus connections of a base to its coordinator and its table.

use std::sync::atomic::{AtomicBool, Ordering};

use shm_bus::{Bus, Publisher, Subscriber, now_ns, writer_epoch};
use shm_schemas::{AgentSensors, BaseCommand, BaseState, Stamp, WheelCommands, service};
use sim_backend::course::{Host, Wheels};

use crate::failure::Failure;
use crate::session::Session;
use crate::wait::Wait;

/// Accepts only answers to the newest request. The repeated time stamp also excludes answers to an
/// earlier host.
pub(super) struct Ports {
    states: Publisher<BaseState>,
    commands: Subscriber<BaseCommand>,
    sensors: Publisher<AgentSensors>,
    wheels: Subscriber<WheelCommands>,
    stamp: Stamp,
    asked: AgentSensors,
    answered: WheelCommands,
}

impl Ports {
    pub(super) fn open(bus: &Bus) -> Result<Self, Failure> {
        Ok(Self {
            states: bus.publisher(service::BASE_STATE)?,
            commands: bus.subscriber(service::BASE_COMMAND)?,
            sensors: bus.publisher(service::AGENT_SENSORS)?,
            wheels: bus.subscriber(service::WHEEL_COMMANDS)?,
            stamp: Stamp {
                writer_epoch: writer_epoch(),
                ..Stamp::default()
            },
            asked: AgentSensors {
                agent_count: 1,
                field_hash: Host::field_hash(),
                ..AgentSensors::default()
            },
            answered: WheelCommands::default(),
        })
    }

    /// Requests the coordinator's command; returns `None` if the process must end.
    pub(super) fn request_command(
        &mut self,
        state: BaseState,
        session: &Session,
        stop: &AtomicBool,
    ) -> Result<Option<BaseCommand>, Failure> {
        let stamp = self.stamp();
        self.states.send(&BaseState { stamp, ..state })?;
        let (wait, mut command) = (Wait::begin(), BaseCommand::default());
        while !stop.load(Ordering::Relaxed) {
            let has_come = self.commands.newest(&mut command)?;
            let fits = command.frame == state.frame
                && command.stamp.captured_ns == stamp.captured_ns
                && command.owner.is_known()
                && command.light.is_known();
            if has_come && fits {
                return Ok(Some(command));
            }
            wait.pause(|| {
                self.states.connect_readers()?;
                session.connect_readers()
            })?;
        }
        Ok(None)
    }

    /// Requests the table's response; returns `None` if the process must end.
    pub(super) fn look_up(
        &mut self,
        row: u8,
        frame: u64,
        stop: &AtomicBool,
    ) -> Result<Option<Wheels>, Failure> {
        self.asked.stamp = self.stamp();
        (self.asked.frame, self.asked.row[0]) = (frame, row.into());
        self.sensors.send(&self.asked)?;
        let wait = Wait::begin();
        while !stop.load(Ordering::Relaxed) {
            let (asked, answered) = (&self.asked, &mut self.answered);
            let has_come = self.wheels.newest(answered)?;
            let fits = answered.frame == frame
                && answered.stamp.captured_ns == asked.stamp.captured_ns
                && answered.agent_count == 1;
            if has_come && fits {
                return Ok(Some(Wheels::from_motor_bits(answered.output[0])));
            }
            wait.pause(|| Ok(self.sensors.connect_readers()?))?;
        }
        Ok(None)
    }

    fn stamp(&mut self) -> Stamp {
        self.stamp.sequence += 1;
        self.stamp.captured_ns = now_ns();
        self.stamp
    }
}
