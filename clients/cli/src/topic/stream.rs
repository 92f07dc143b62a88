//! Uniform reading of streams with any payload type.

use atas_client::{Session, json};
use atas_console::{Exit, ExitError};
use serde_json::Value;
use shm_bus::{BusError, Stream, Subscriber};
use shm_schemas::{
    AgentSensors, ArenaTruth, BaseCommand, BaseState, ModuleEvent, Payload, RunHeader,
    SensorStatus, Stamp, Status, TickReport, View, WheelCommands, WorldTruth,
};

/// Most payloads read at once: the whole queue.
const BATCH: usize = 1024;

pub(super) struct Received {
    pub(super) stamp: Stamp,
    /// JSON content, or null if only the count is needed.
    pub(super) value: Value,
}

/// Reader of a stream with any payload type.
pub(super) trait StreamReader {
    /// Appends all waiting payloads; `values` selects their content as well.
    fn read_waiting(&mut self, values: bool, reported: &mut Vec<Received>) -> Result<(), BusError>;
}

/// Payload that observers may read.
trait Readable: Payload {
    fn stamp(&self) -> Stamp;
    fn value(&self) -> Value;
}

impl<T: Readable> StreamReader for Subscriber<T> {
    fn read_waiting(&mut self, values: bool, reported: &mut Vec<Received>) -> Result<(), BusError> {
        self.drain(BATCH, |payload| {
            let value = if values { payload.value() } else { Value::Null };
            reported.push(Received {
                stamp: payload.stamp(),
                value,
            });
        })?;
        Ok(())
    }
}

macro_rules! readable {
    ($($payload:ident by $value:path;)*) => {
        $(impl Readable for $payload {
            fn stamp(&self) -> Stamp {
                self.stamp
            }

            fn value(&self) -> Value {
                $value(self)
            }
        })*

        pub(super) fn is_readable(stream: &Stream) -> bool {
            [$(<$payload as Payload>::TYPE_NAME),*].contains(&stream.payload)
        }

        fn subscribe(session: &Session, stream: &Stream) -> Result<Option<Box<dyn StreamReader>>, BusError> {
            $(if stream.payload == <$payload as Payload>::TYPE_NAME {
                return Ok(Some(Box::new(session.bus().subscriber::<$payload>(stream.service)?)));
            })*
            Ok(None)
        }
    };
}

readable! {
    Status by status;
    TickReport by json::report;
    View by json::view;
    ModuleEvent by json::event;
    RunHeader by json::run;
    SensorStatus by json::sensor;
    WorldTruth by json::truth;
    AgentSensors by json::agents;
    WheelCommands by json::wheels;
    BaseState by json::base;
    BaseCommand by json::base_command;
    ArenaTruth by json::arena;
}

/// Converts a status without knowledge of the run: all fingertip slots are included.
fn status(status: &Status) -> Value {
    json::status(status, json::CAPACITY)
}

pub(super) fn open(
    session: &Session,
    stream: &'static Stream,
) -> anyhow::Result<Box<dyn StreamReader>> {
    let Some(received) = subscribe(session, stream)? else {
        let sentence = format!(
            "could not read {}: only the control loop may read it, so that observers cannot delay \
             the loop; use `atas topic echo view` for the newest frames and joints, `atas status` \
             for rates",
            stream.service
        );
        return Err(ExitError::with_code(Exit::Usage, sentence));
    };
    Ok(received)
}
