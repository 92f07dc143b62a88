//! Recorded payloads: plain bytes of bus payloads, each on a channel whose schema describes the
//! layout.

use shm_schemas::{
    ModuleEvent, Payload, RunHeader, SensorStatus, Stamp, Status, TickInputs, TickReport, service,
};

/// Encoding of messages and schemas: the bytes of a `#[repr(C)]` payload, described as text.
pub(crate) const POD: &str = "atas-pod";

/// Payload type that is recorded.
pub trait Recorded: Payload {
    /// Channel in the file: the name of the service.
    const TOPIC: &'static str;
    /// Stamp of the payload.
    fn stamp(&self) -> &Stamp;
}

macro_rules! recorded {
    ($($payload:ident at $topic:expr;)*) => {
        $(impl Recorded for $payload {
            const TOPIC: &'static str = $topic;

            fn stamp(&self) -> &Stamp {
                &self.stamp
            }
        })*

        /// All recorded payload types.
        #[cfg(test)]
        pub(crate) const RECORDED: &[&shm_schemas::schema::PayloadType] = &[$($payload::SCHEMA),*];
    };
}

recorded! {
    RunHeader at service::RUN_HEADER;
    TickInputs at service::TICK_INPUTS;
    TickReport at service::TICK_REPORT;
    ModuleEvent at service::MODULE_EVENT;
    Status at service::STATUS;
    SensorStatus at service::SENSOR_STATUS;
}
