//! Streams of any payload, read alike.

use atas_client::{Session, json};
use atas_console::{Ended, Exit};
use serde_json::Value;
use shm_bus::{BusError, Stream, Subscriber};
use shm_schemas::{
    AgentSensors, ArenaTruth, BaseCommand, BaseState, ModuleEvent, Payload, RunHeader,
    SensorStatus, Stamp, Status, TickReport, View, WheelCommands, WorldTruth,
};

/// Most payloads taken in one look: all that can wait.
const AT_ONCE: usize = 1024;

/// One payload.
pub(super) struct Told {
    pub(super) stamp: Stamp,
    /// What it says; nothing where only the count matters.
    pub(super) value: Value,
}

/// A stream of some payload.
pub(super) trait Heard {
    /// Takes what waits; with `values`, also what it says.
    fn listen(&mut self, values: bool, told: &mut Vec<Told>) -> Result<(), BusError>;
}

/// A payload that observers may read.
trait Readable: Payload {
    fn stamp(&self) -> Stamp;
    fn value(&self) -> Value;
}

impl<T: Readable> Heard for Subscriber<T> {
    fn listen(&mut self, values: bool, told: &mut Vec<Told>) -> Result<(), BusError> {
        self.drain(AT_ONCE, |payload| {
            let value = if values { payload.value() } else { Value::Null };
            told.push(Told {
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

        /// Whether observers may read it.
        pub(super) fn is_readable(stream: &Stream) -> bool {
            [$(<$payload as Payload>::TYPE_NAME),*].contains(&stream.payload)
        }

        fn subscribe(session: &Session, stream: &Stream) -> Result<Option<Box<dyn Heard>>, BusError> {
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

/// As it travels: whoever reads along need not know the run.
fn status(status: &Status) -> Value {
    json::status(status, json::ROOM)
}

/// Begins to read a stream that observers may read.
pub(super) fn open(session: &Session, stream: &'static Stream) -> anyhow::Result<Box<dyn Heard>> {
    let Some(heard) = subscribe(session, stream)? else {
        let sentence = format!(
            "{} belongs to the control loop, whose readers are a closed set so that nobody slows it; `atas topic echo view` \
             shows its newest frames and joints, `atas status` its rates",
            stream.service
        );
        return Err(Ended::with(Exit::Usage, sentence));
    };
    Ok(heard)
}
