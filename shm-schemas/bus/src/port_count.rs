//! Numbers of writers and readers of a stream, for diagnosis.

use iceoryx2::prelude::ServiceName;
use iceoryx2::service::builder::publish_subscribe::PublishSubscribeOpenError as OpenError;
use iceoryx2::service::port_factory::PortFactory as _;
use shm_schemas::{
    AgentSensors, ArenaTruth, BaseCommand, BaseState, GraspTarget, HandFrame, JointCommand,
    JointState, ModuleEvent, Payload, RunHeader, SensorStatus, Status, TickInputs, TickReport,
    View, WheelCommands, WorldTruth,
};

use crate::bus::Bus;
use crate::error::BusError;
use crate::qos::Stream;

/// Ports that are open on a stream.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PortCount {
    /// Number of writers.
    pub writers: usize,
    /// Number of readers.
    pub readers: usize,
}

impl Bus {
    /// Counts writers and readers of a stream without opening a port or creating the service. Zero
    /// if it does not exist.
    ///
    /// # Errors
    /// [`BusError::Open`] if a peer of another version has the stream open.
    pub fn port_count(&self, stream: &'static Stream) -> Result<PortCount, BusError> {
        macro_rules! count {
            ($($payload:ident)*) => {
                match stream.payload {
                    $(<$payload as Payload>::TYPE_NAME => self.count_ports::<$payload>(stream),)*
                    _ => Ok(PortCount::default()),
                }
            };
        }
        count! {
            HandFrame JointState JointCommand Status TickReport View ModuleEvent RunHeader TickInputs SensorStatus WorldTruth
            AgentSensors WheelCommands BaseState BaseCommand ArenaTruth GraspTarget
        }
    }

    fn count_ports<T: Payload>(&self, stream: &'static Stream) -> Result<PortCount, BusError> {
        let member = &self.member;
        let name = ServiceName::new(stream.service)
            .map_err(|e| member.refused_error(stream.service, &e))?;
        let service = member.node.service_builder(&name).publish_subscribe::<T>();
        match service.open() {
            Ok(factory) => Ok(PortCount {
                writers: factory.dynamic_config().number_of_publishers(),
                readers: factory.dynamic_config().number_of_subscribers(),
            }),
            Err(OpenError::DoesNotExist) => Ok(PortCount::default()),
            Err(error) => Err(member.refused_error(stream.service, &error)),
        }
    }
}
