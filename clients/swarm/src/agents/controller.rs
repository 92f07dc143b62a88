//! Controller that answers the frames of a field on the bus.

use field::Preset;
use serde::Serialize;
use shm_bus::{Bus, Publisher, Subscriber, writer_epoch};
use shm_schemas::capacity::AGENTS;
use shm_schemas::{AgentSensors, WheelCommands, service};

use super::{Exchange, Lookup};
use crate::error::{Error, Result};

/// Fields that the tables may drive.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FieldPolicy {
    /// The field that they were evolved for.
    SameField,
    /// Any hosted field, to test tables elsewhere.
    Any,
}

/// Frame counters of a controller.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Counts {
    /// Frames answered.
    pub answered: u64,
    /// Frames missed because a newer one replaced them.
    pub lost: u64,
    /// Frames with more agents than a payload can hold; not answered.
    pub malformed: u64,
}

/// Controller of all agents of the fields on a bus.
pub struct TeamController {
    subscriber: Subscriber<AgentSensors>,
    publisher: Publisher<WheelCommands>,
    sensors: AgentSensors,
    commands: WheelCommands,
    lookup: Lookup,
    fields: FieldPolicy,
    counts: Counts,
}

impl TeamController {
    /// Joins the bus with initial tables.
    ///
    /// # Errors
    /// The bus cannot be used, or another process already answers on it.
    pub fn open(bus: &Bus, lookup: Lookup, fields: FieldPolicy) -> Result<Self> {
        let mut commands = WheelCommands::default();
        commands.stamp.writer_epoch = writer_epoch();
        Ok(Self {
            publisher: bus.publisher(service::WHEEL_COMMANDS)?,
            subscriber: bus.subscriber(service::AGENT_SENSORS)?,
            sensors: AgentSensors::default(),
            commands,
            lookup,
            fields,
            counts: Counts::default(),
        })
    }

    /// Answers the newest frame, if one arrived, after taking offered tables. Returns whether a
    /// frame arrived.
    ///
    /// # Errors
    /// The field does not match the tables: the frame is not answered and the robots stand still.
    /// Or shared memory is damaged.
    pub fn answer(&mut self, exchange: &Exchange) -> Result<bool> {
        let before = self.sensors.stamp;
        if !self.subscriber.newest(&mut self.sensors)? {
            return Ok(false);
        }
        exchange.take(&mut self.lookup);
        let asked = &self.sensors;
        if self.fields == FieldPolicy::SameField && asked.field_hash != self.lookup.field_hash() {
            return Err(field_mismatch(asked.field_hash, self.lookup.field_hash()));
        }
        if asked.stamp.writer_epoch == before.writer_epoch {
            let step = asked.stamp.sequence.saturating_sub(before.sequence);
            self.counts.lost += step.saturating_sub(1);
        }
        let count = asked.agent_count as usize;
        if count > AGENTS {
            self.counts.malformed += 1;
            return Ok(true);
        }
        let commands = &mut self.commands;
        commands.stamp.captured_ns = asked.stamp.captured_ns;
        (commands.trial, commands.frame) = (asked.trial, asked.frame);
        commands.agent_count = asked.agent_count;
        commands.table_hash = self.lookup.hash();
        self.lookup
            .answer(&asked.row[..count], &mut commands.output);
        self.publisher.send(commands)?;
        commands.stamp.sequence += 1;
        self.counts.answered += 1;
        Ok(true)
    }

    /// Returns the frame counters.
    #[must_use]
    pub fn counts(&self) -> Counts {
        self.counts
    }
}

fn field_mismatch(field: u64, tables: u64) -> Error {
    Error::refused(
        "drive the robots",
        format_args!("their field is {}", field_name(field)),
        format_args!("the field of the tables, {}", field_name(tables)),
        "host that field (atas-sim field --preset), use tables of this field, or give --any-field",
    )
}

fn field_name(field_hash: u64) -> String {
    let named = Preset::ALL
        .into_iter()
        .find(|preset| preset.fingerprint() == field_hash);
    named.map_or_else(
        || format!("a custom one ({field_hash:016x})"),
        |preset| preset.name.into_owned(),
    )
}
