//! Writer of one MCAP file.

use std::collections::{BTreeMap, HashMap};
use std::fs::{File, OpenOptions};
use std::io::BufWriter;
use std::path::{Path, PathBuf};

use anyhow::Context;
use mcap::records::{MessageHeader, Metadata};
use mcap::{Compression, WriteOptions};
use serde_json::Value;
use shm_schemas::Stamp;

use super::follower;
use super::payloads::{POD, Recorded};
use super::schema::schema;

/// Bytes per compressed chunk. Design choice: a tenth of a second at 1 kHz.
const CHUNK_BYTES: u64 = 1 << 20;
/// Level of zstd. Design choice: the fastest; frames are mostly noise, which no level compresses.
const LEVEL: u32 = 1;
/// Schema of JSON messages: any object.
const ANY_OBJECT: &[u8] = br#"{"type":"object"}"#;

/// Schema of a state.
const ANY_STATE: &[u8] =
    b"a map of the controller's fields by their names, of the version in the field `version`";

/// Open file. Dropping it writes the footer if the disk permits.
pub(super) struct Writer {
    mcap: mcap::Writer<BufWriter<File>>,
    channels: HashMap<&'static str, u16>,
    path: PathBuf,
    /// Bytes of messages since the last flush, before compression.
    unflushed: u64,
}

impl Writer {
    /// Creates a new file; never overwrites one.
    pub(super) fn create(path: &Path) -> anyhow::Result<Self> {
        let file = OpenOptions::new().write(true).create_new(true).open(path);
        let file = file.with_context(|| format!("could not make the file {}", path.display()))?;
        let options = WriteOptions::new()
            .profile("atas")
            .library(concat!("atas ", env!("CARGO_PKG_VERSION")))
            .compression(Some(Compression::Zstd))
            .compression_level(LEVEL)
            .compression_threads(0)
            .chunk_size(Some(CHUNK_BYTES));
        let mcap = options.create(BufWriter::new(file));
        Ok(Self {
            mcap: mcap.with_context(|| format!("could not write {}", path.display()))?,
            channels: HashMap::new(),
            path: path.to_owned(),
            unflushed: 0,
        })
    }

    pub(super) fn path(&self) -> &Path {
        &self.path
    }

    /// Writes a payload as its bytes.
    pub(super) fn write<T: Recorded>(&mut self, payload: &T) -> anyhow::Result<()> {
        let schema = || (T::TYPE_NAME, schema(T::SCHEMA).into_bytes());
        let channel = self.channel(T::TOPIC, POD, POD, schema)?;
        self.message(channel, payload.stamp(), payload.as_bytes())
    }

    /// Writes a payload as JSON, for viewers.
    pub(super) fn write_json(
        &mut self,
        topic: &'static str,
        stamp: &Stamp,
        value: &Value,
    ) -> anyhow::Result<()> {
        let schema = || ("atas.json", ANY_OBJECT.to_vec());
        let channel = self.channel(topic, "json", "jsonschema", schema)?;
        self.message(channel, stamp, value.to_string().as_bytes())
    }

    /// Writes the encoded controller state from which the next part continues.
    pub(super) fn write_state(&mut self, last: &Stamp, state: &[u8]) -> anyhow::Result<()> {
        let schema = || ("atas.ControllerState", ANY_STATE.to_vec());
        let channel = self.channel(follower::TOPIC, follower::ENCODING, "text", schema)?;
        self.message(channel, last, state)
    }

    /// Writes a message of another file.
    pub(super) fn copy(&mut self, message: &mcap::Message<'_>) -> anyhow::Result<()> {
        self.done(|mcap| mcap.write(message))
    }

    /// Writes metadata.
    pub(super) fn describe(&mut self, metadata: &Metadata) -> anyhow::Result<()> {
        self.done(|mcap| mcap.write_metadata(metadata))
    }

    /// Returns the bytes of messages since the last flush, before compression: an upper bound of
    /// the growth of the file.
    pub(super) fn unflushed(&self) -> u64 {
        self.unflushed
    }

    /// Passes all data to the operating system, so that the end of this process loses nothing.
    /// Returns the size of the file.
    pub(super) fn flush(&mut self) -> anyhow::Result<u64> {
        self.done(mcap::Writer::flush)?;
        self.unflushed = 0;
        self.size()
    }

    /// Writes the footer and returns the size of the file.
    pub(super) fn finish(mut self) -> anyhow::Result<u64> {
        self.done(|mcap| mcap.finish().map(|_summary| ()))?;
        self.size()
    }

    fn size(&self) -> anyhow::Result<u64> {
        let meta = std::fs::metadata(&self.path);
        let meta = meta.with_context(|| format!("could not examine {}", self.path.display()))?;
        Ok(meta.len())
    }

    fn channel(
        &mut self,
        topic: &'static str,
        message_encoding: &str,
        schema_encoding: &str,
        schema: impl FnOnce() -> (&'static str, Vec<u8>),
    ) -> anyhow::Result<u16> {
        if let Some(channel) = self.channels.get(topic) {
            return Ok(*channel);
        }
        let (name, text) = schema();
        let schema = self.mcap.add_schema(name, schema_encoding, &text)?;
        let channel = self
            .mcap
            .add_channel(schema, topic, message_encoding, &BTreeMap::new())?;
        self.channels.insert(topic, channel);
        Ok(channel)
    }

    fn message(&mut self, channel_id: u16, stamp: &Stamp, data: &[u8]) -> anyhow::Result<()> {
        self.unflushed += data.len() as u64;
        let header = MessageHeader {
            channel_id,
            // The format has 32 bits; the stamp in the message has all.
            sequence: stamp.sequence as u32,
            log_time: stamp.captured_ns,
            publish_time: stamp.captured_ns,
        };
        self.done(|mcap| mcap.write_to_known_channel(&header, data))
    }

    fn done(
        &mut self,
        write: impl FnOnce(&mut mcap::Writer<BufWriter<File>>) -> mcap::McapResult<()>,
    ) -> anyhow::Result<()> {
        write(&mut self.mcap).with_context(|| format!("could not write {}", self.path.display()))
    }
}
