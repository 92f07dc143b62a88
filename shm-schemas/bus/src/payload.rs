//! Payloads of the streams, and opening of their ports.

use shm_schemas::{
    AgentSensors, ArenaTruth, BaseCommand, BaseState, GraspTarget, HandFrame, JointCommand,
    JointState, ModuleEvent, Payload, RunHeader, SensorStatus, Status, TickInputs, TickReport,
    View, WheelCommands, WorldTruth,
};

use crate::bus::Bus;
use crate::error::BusError;
use crate::publisher::Publisher;
use crate::qos::Stream;
use crate::shortage::require_stack;
use crate::stream::find_stream;
use crate::subscriber::Subscriber;

impl Bus {
    /// Opens a writer of a stream in [`crate::STREAMS`].
    ///
    /// # Errors
    /// [`BusError::Taken`], naming the process, if the stream has its writer already;
    /// [`BusError::NoSpace`] if `/dev/shm` is too full.
    pub fn publisher<T: StreamPayload>(&self, service: &str) -> Result<Publisher<T>, BusError> {
        let stream = find_stream::<T>(service)?;
        require_stack(stream.service)?;
        T::make_publisher(self, stream)
    }

    /// Opens a reader of a stream in [`crate::STREAMS`]. Writers may start and end at any time.
    ///
    /// # Errors
    /// [`BusError::Full`] if all reader slots are taken; [`BusError::NoSpace`] if `/dev/shm` is too
    /// full.
    pub fn subscriber<T: StreamPayload>(&self, service: &str) -> Result<Subscriber<T>, BusError> {
        let stream = find_stream::<T>(service)?;
        require_stack(stream.service)?;
        T::make_subscriber(self, stream)
    }
}

/// Payload of a stream.
///
/// The functions are not generic. Therefore iceoryx2's code for a payload is compiled once, in this
/// crate, and not in every program.
pub trait StreamPayload: Payload {
    #[doc(hidden)]
    fn make_publisher(bus: &Bus, stream: &'static Stream) -> Result<Publisher<Self>, BusError>;
    #[doc(hidden)]
    fn make_subscriber(bus: &Bus, stream: &'static Stream) -> Result<Subscriber<Self>, BusError>;
}

macro_rules! stream_payloads {
    ($($payload:ty),*) => {$(
        impl StreamPayload for $payload {
            fn make_publisher(
                bus: &Bus,
                stream: &'static Stream,
            ) -> Result<Publisher<Self>, BusError> {
                bus.make_publisher(stream)
            }

            fn make_subscriber(
                bus: &Bus,
                stream: &'static Stream,
            ) -> Result<Subscriber<Self>, BusError> {
                bus.make_subscriber(stream)
            }
        }
    )*};
}
stream_payloads! { AgentSensors, ArenaTruth, BaseCommand, BaseState, GraspTarget, HandFrame }
stream_payloads! { JointCommand, JointState, ModuleEvent, RunHeader, SensorStatus, Status }
stream_payloads! { TickInputs, TickReport, View, WheelCommands, WorldTruth }
