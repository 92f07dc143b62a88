//! Reader of one MCAP file, from its beginning, in bounded memory. A truncated or damaged file is
//! read up to the damage; then follows an error.

// Numbers of a file or a device reach this arithmetic.
#![warn(clippy::arithmetic_side_effects)]

use std::borrow::Cow;
use std::fs::File;
use std::io::{BufReader, Read};
use std::path::{Path, PathBuf};

use anyhow::Context;
use mcap::Message;
use mcap::read::ChannelAccumulator;
use mcap::records::{Metadata, Record, op};
use mcap::sans_io::{LinearReadEvent, LinearReader, LinearReaderOptions};

use super::payloads::Recorded;

/// Longest accepted record or chunk in a large file, bytes: a hundred times a chunk. A damaged
/// length must not exhaust memory.
const RECORD_MAX_BYTES: u64 = 128 << 20;
/// Longest accepted record or chunk in a small file, bytes: sixteen chunks, which may be compressed
/// to little. A damaged length in a small file must not cost the memory of a large one.
const SMALL_RECORD_MAX_BYTES: u64 = 16 << 20;

/// First bytes of every MCAP file.
const MAGIC: &[u8] = b"\x89MCAP";

/// Returns true if a file is a recording, by its first bytes.
///
/// # Errors
/// The file cannot be opened or read.
pub fn is_recording(path: &Path) -> anyhow::Result<bool> {
    let file = File::open(path).with_context(|| format!("could not open {}", path.display()))?;
    let mut begin = Vec::new();
    let read = file.take(MAGIC.len() as u64).read_to_end(&mut begin);
    read.with_context(|| format!("could not read {}", path.display()))?;
    Ok(begin == MAGIC)
}

/// Entry of a file.
pub enum Entry {
    /// Message with its channel.
    Message(Message<'static>),
    /// Named table of texts.
    Metadata(Metadata),
}

/// Iterator over the entries of a file.
pub struct Reader {
    file: BufReader<File>,
    records: LinearReader,
    /// Parser of the chunks.
    chunk_records: LinearReader,
    chunk: Option<Chunk>,
    channels: ChannelAccumulator<'static>,
    path: PathBuf,
    has_ended: bool,
}

impl Reader {
    /// Opens a file.
    ///
    /// # Errors
    /// The file cannot be opened.
    pub fn open(path: &Path) -> anyhow::Result<Self> {
        let file =
            File::open(path).with_context(|| format!("could not open {}", path.display()))?;
        let length = file.metadata().map_or(RECORD_MAX_BYTES, |file| file.len());
        let length = length.clamp(SMALL_RECORD_MAX_BYTES, RECORD_MAX_BYTES);
        let options = LinearReaderOptions::default()
            .with_validate_chunk_crcs(true)
            .with_prevalidate_chunk_crcs(true)
            .with_record_length_limit(usize::try_from(length).unwrap_or(usize::MAX));
        let chunks = options.clone().with_skip_start_magic(true);
        let records = options
            .with_emit_chunks(true)
            .with_validate_data_section_crc(true)
            .with_validate_summary_section_crc(true);
        Ok(Self {
            file: BufReader::new(file),
            records: LinearReader::new_with_options(records),
            chunk_records: LinearReader::new_with_options(chunks),
            chunk: None,
            channels: ChannelAccumulator::default(),
            path: path.to_owned(),
            has_ended: false,
        })
    }

    /// Returns the error text where reading stops. A recording can be repaired, another file
    /// cannot.
    fn unreadable(&self) -> String {
        let path = self.path.display();
        // A file that can no longer be opened was readable before.
        if is_recording(&self.path).unwrap_or(true) {
            format!(
                "could not read {path} to its end; save the readable part with `atas record repair \
                 {path}`"
            )
        } else {
            format!(
                "could not read {path} because it does not begin as a recording does, needs a file that `atas record` wrote; \
                 name another"
            )
        }
    }

    fn next_entry(&mut self) -> anyhow::Result<Option<Entry>> {
        loop {
            if let Some(chunk) = &mut self.chunk {
                match chunk.next_entry(&mut self.chunk_records, &mut self.channels)? {
                    Some(entry) => return Ok(Some(entry)),
                    None => self.chunk = None,
                }
            }
            let Some(event) = self.records.next_event() else {
                return Ok(None);
            };
            match event? {
                LinearReadEvent::ReadRequest(bytes) => {
                    let read = self.file.read(self.records.insert(bytes))?;
                    self.records.notify_read(read);
                }
                LinearReadEvent::Record { data, opcode } => {
                    if opcode == op::CHUNK {
                        self.chunk = Some(Chunk::new(data)?);
                    } else if let Some(entry) = entry_of(&mut self.channels, opcode, data)? {
                        return Ok(Some(entry));
                    }
                }
            }
        }
    }
}

/// Chunk of a file. It is examined before the parser receives it: the parser panics if a record is
/// longer than its chunk.
struct Chunk {
    record: Vec<u8>,
    /// Number of bytes that the parser has received.
    read: usize,
}

impl Chunk {
    fn new(data: &[u8]) -> anyhow::Result<Self> {
        anyhow::ensure!(texts_fit(op::CHUNK, data), "a chunk is too short");
        if let Record::Chunk { header, data } = mcap::parse_record(op::CHUNK, data)? {
            let is_plain = header.compression.is_empty();
            anyhow::ensure!(
                !is_plain || records_fit(&data),
                "a record is longer than its chunk"
            );
        }
        let length = data.len() as u64;
        Ok(Self {
            record: [&[op::CHUNK], &length.to_le_bytes()[..], data].concat(),
            read: 0,
        })
    }

    /// Returns the next entry; `None` at the end of the chunk.
    fn next_entry(
        &mut self,
        records: &mut LinearReader,
        channels: &mut ChannelAccumulator<'static>,
    ) -> anyhow::Result<Option<Entry>> {
        while let Some(event) = records.next_event() {
            match event? {
                LinearReadEvent::ReadRequest(bytes) => {
                    let rest = self.record.get(self.read..).unwrap_or_default();
                    // The parser requests the next chunk.
                    if rest.is_empty() {
                        return Ok(None);
                    }
                    let given = rest.get(..bytes).unwrap_or(rest);
                    records.insert(bytes)[..given.len()].copy_from_slice(given);
                    records.notify_read(given.len());
                    self.read = self.read.saturating_add(given.len());
                }
                LinearReadEvent::Record { data, opcode } => {
                    if let Some(entry) = entry_of(channels, opcode, data)? {
                        return Ok(Some(entry));
                    }
                }
            }
        }
        Ok(None)
    }
}

/// Returns true if every record of an uncompressed chunk ends inside it.
fn records_fit(mut records: &[u8]) -> bool {
    while let Some((_, rest)) = records.split_first() {
        let rest = rest.split_first_chunk().and_then(|(length, rest)| {
            let length = usize::try_from(u64::from_le_bytes(*length)).ok()?;
            rest.get(length..)
        });
        let Some(rest) = rest else {
            return false;
        };
        records = rest;
    }
    true
}

/// Returns true for records with entries. The parser is not called for others: it panics on a short
/// attachment.
fn is_read(opcode: u8) -> bool {
    matches!(
        opcode,
        op::SCHEMA | op::CHANNEL | op::MESSAGE | op::METADATA
    )
}

/// Returns true if every text fits into its record. The parser allocates a text before it reads it,
/// up to 4 GiB for a damaged length.
fn texts_fit(opcode: u8, record: &[u8]) -> bool {
    let rest = match opcode {
        op::SCHEMA => record.get(2..).and_then(skip_text).and_then(skip_text),
        op::CHANNEL => record
            .get(4..)
            .and_then(skip_text)
            .and_then(skip_text)
            .and_then(skip_table),
        op::METADATA => skip_text(record).and_then(skip_table),
        op::CHUNK => record.get(28..).and_then(skip_text),
        _ => Some(record),
    };
    rest.is_some()
}

/// Returns the bytes after a text; `None` if it is longer.
fn skip_text(bytes: &[u8]) -> Option<&[u8]> {
    let (length, rest) = bytes.split_first_chunk()?;
    rest.get(usize::try_from(u32::from_le_bytes(*length)).ok()?..)
}

/// Returns the bytes after a table of texts; `None` if it is longer.
fn skip_table(bytes: &[u8]) -> Option<&[u8]> {
    let after = skip_text(bytes)?;
    let table = bytes.get(..bytes.len().checked_sub(after.len())?)?;
    let mut texts = table.get(4..)?;
    while !texts.is_empty() {
        texts = skip_text(texts)?;
    }
    Some(after)
}

/// Parses a record; returns its entry, if it has one.
fn entry_of(
    channels: &mut ChannelAccumulator<'static>,
    opcode: u8,
    data: &[u8],
) -> anyhow::Result<Option<Entry>> {
    if !is_read(opcode) {
        return Ok(None);
    }
    anyhow::ensure!(
        texts_fit(opcode, data),
        "a text is longer than its record {opcode:#04x}"
    );
    match mcap::parse_record(opcode, data)? {
        Record::Schema { header, data } => {
            channels.add_schema(header, Cow::Owned(data.into_owned()))?;
        }
        Record::Channel(channel) => channels.add_channel(channel)?,
        Record::Message { header, data } => {
            let unknown = mcap::McapError::UnknownChannel(header.sequence, header.channel_id);
            return Ok(Some(Entry::Message(Message {
                channel: channels.get(header.channel_id).ok_or(unknown)?,
                sequence: header.sequence,
                log_time: header.log_time,
                publish_time: header.publish_time,
                data: Cow::Owned(data.into_owned()),
            })));
        }
        Record::Metadata(metadata) => return Ok(Some(Entry::Metadata(metadata))),
        _ => {}
    }
    Ok(None)
}

impl Iterator for Reader {
    type Item = anyhow::Result<Entry>;

    fn next(&mut self) -> Option<Self::Item> {
        if self.has_ended {
            return None;
        }
        let entry = self.next_entry().with_context(|| self.unreadable());
        self.has_ended = !matches!(entry, Ok(Some(_)));
        entry.transpose()
    }
}

/// Returns the payload of a message if it has this type.
///
/// # Errors
/// The payload has another version of this type; this is reported, not skipped.
pub fn payload<T: Recorded>(message: &Message<'_>) -> anyhow::Result<Option<Box<T>>> {
    let Some(schema) = &message.channel.schema else {
        return Ok(None);
    };
    if stem(&schema.name) != stem(T::TYPE_NAME) {
        return Ok(None);
    }
    anyhow::ensure!(
        schema.name == T::TYPE_NAME,
        "could not read {} because this version of atas reads {}; use the version that recorded it (metadata {:?}, \
         daemon_version)",
        schema.name,
        T::TYPE_NAME,
        crate::rotation::ORIGIN
    );
    let read = T::read_from_bytes(&message.data).ok();
    let read = read.with_context(|| {
        let (bytes, needed) = (message.data.len(), size_of::<T>());
        format!(
            "could not read {} because it has {bytes} bytes, needs {needed}; the file is damaged",
            schema.name
        )
    })?;
    Ok(Some(Box::new(read)))
}

/// Returns the name of a type without its version.
fn stem(name: &str) -> &str {
    name.rsplit_once(".v").map_or(name, |(stem, _)| stem)
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;
    use std::sync::Arc;

    use mcap::{Channel, Schema};
    use shm_schemas::{Payload, Stamp, Status, TickInputs};
    use zerocopy::IntoBytes;

    use super::*;

    fn message(schema: Option<&str>, data: Vec<u8>) -> Message<'static> {
        let schema = schema.map(|name| {
            Arc::new(Schema {
                id: 1,
                name: name.to_owned(),
                encoding: crate::payloads::POD.to_owned(),
                data: Cow::Borrowed(&[]),
            })
        });
        Message {
            channel: Arc::new(Channel {
                id: 1,
                topic: "some/topic".to_owned(),
                schema,
                message_encoding: crate::payloads::POD.to_owned(),
                metadata: BTreeMap::new(),
            }),
            sequence: 0,
            log_time: 0,
            publish_time: 0,
            data: Cow::Owned(data),
        }
    }

    #[test]
    fn other_file_is_rejected_without_repair_hint() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("some.file");
        let check = |bytes: &[u8], is_one: bool| {
            std::fs::write(&path, bytes).expect("written");
            let entries = Reader::open(&path).expect("opened");
            let errors: Vec<String> = entries
                .filter_map(|entry| Some(format!("{:#}", entry.err()?)))
                .collect();
            let [error] = &errors[..] else {
                panic!("{bytes:?}: {errors:?}");
            };
            assert_eq!(error.contains("`atas record repair"), is_one, "{error}");
            assert_eq!(error.contains("needs a file that"), !is_one, "{error}");
        };
        check(b"[[task]]\nname = \"polish\"\n", false);
        check(b"", false);
        check(&MAGIC[..3], false);
        check(&[MAGIC, b"0\r\n"].concat(), true);
        check(&[MAGIC, b"0\r\n and then something else"].concat(), true);
    }

    /// Returns a file of one record.
    fn file_of(opcode: u8, length: u64, content: &[u8]) -> Vec<u8> {
        let mut file = [MAGIC, b"0\r\n", &[opcode]].concat();
        file.extend(length.to_le_bytes());
        file.extend(content);
        file
    }

    fn errors_of(file: &[u8]) -> Vec<String> {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("some.mcap");
        std::fs::write(&path, file).expect("written");
        let entries = Reader::open(&path).expect("opened");
        entries
            .filter_map(|entry| Some(format!("{:#}", entry.err()?)))
            .collect()
    }

    /// Regression: the parser allocated up to 4 GiB for a text with a damaged length.
    #[test]
    fn text_longer_than_its_record_is_rejected() {
        let long = u32::MAX.to_le_bytes();
        let check = |opcode: u8, before: &[u8]| {
            let content = [before, &long, b"abc"].concat();
            let errors = errors_of(&file_of(opcode, content.len() as u64, &content));
            let is_rejected = matches!(&errors[..], [error] if error.contains("a text is longer"));
            assert!(is_rejected, "{opcode:#x} {before:?}: {errors:?}");
        };
        let text = [1, 0, 0, 0, b'x'];
        check(op::SCHEMA, &[1, 0]);
        check(op::SCHEMA, &[&[1, 0][..], &text].concat());
        check(op::CHANNEL, &[1, 0, 1, 0]);
        check(op::CHANNEL, &[&[1, 0, 1, 0][..], &text, &text].concat());
        check(op::METADATA, &[]);
        check(op::METADATA, &text);
        // A text within a table of eight bytes.
        let table = [&text[..], &[8, 0, 0, 0]].concat();
        let content = [&table[..], &long, b"abcd"].concat();
        let errors = errors_of(&file_of(op::METADATA, content.len() as u64, &content));
        assert!(errors[0].contains("a text is longer"), "{errors:?}");
    }

    /// Regression: the parser panicked on an attachment without its checksum.
    #[test]
    fn short_attachment_is_skipped_without_panic() {
        let mut content = vec![0; 16];
        content.extend([0; 8]);
        content.extend(0_u64.to_le_bytes());
        let errors = errors_of(&file_of(op::ATTACHMENT, content.len() as u64, &content));
        // The file ends after the attachment.
        assert_eq!(errors.len(), 1, "{errors:?}");
    }

    /// Regression: the parser panicked on a record that is longer than its chunk.
    #[test]
    fn record_longer_than_its_chunk_is_rejected() {
        let mut record = vec![op::METADATA];
        record.extend(100_u64.to_le_bytes());
        record.extend([0; 20]);
        let mut chunk = vec![0; 16];
        chunk.extend((record.len() as u64).to_le_bytes());
        // Neither a checksum nor a compression.
        chunk.extend([0; 8]);
        chunk.extend((record.len() as u64).to_le_bytes());
        chunk.extend(&record);
        let mut file = file_of(op::CHUNK, chunk.len() as u64, &chunk);
        file.extend([0; 200]);
        let errors = errors_of(&file);
        assert!(errors[0].contains("longer than its chunk"), "{errors:?}");
    }

    /// Regression: a damaged length in a small file cost 128 MiB.
    #[test]
    fn length_beyond_a_small_file_is_rejected() {
        let errors = errors_of(&file_of(op::MESSAGE, 100 << 20, b"abc"));
        assert!(errors[0].contains("exceeds limit"), "{errors:?}");
    }

    #[test]
    fn payload_of_other_version_is_rejected_by_name() {
        let part = TickInputs {
            stamp: Stamp {
                sequence: 7,
                ..Stamp::default()
            },
            ..TickInputs::default()
        };
        let bytes = || part.as_bytes().to_vec();
        let own = message(Some(TickInputs::TYPE_NAME), bytes());
        let read = payload::<TickInputs>(&own).expect("readable").expect("one");
        assert_eq!(read.stamp.sequence, 7);
        // Other types, or none, are left to other readers.
        for other in [Some(Status::TYPE_NAME), Some("atas.json"), None] {
            let of_another = payload::<TickInputs>(&message(other, bytes()));
            assert!(of_another.expect("no error").is_none(), "{other:?}");
        }
        let check = |schema: &str, data: Vec<u8>, part: &str| {
            let error = payload::<TickInputs>(&message(Some(schema), data))
                .expect_err("must be refused")
                .to_string();
            assert!(error.contains(schema) && error.contains(part), "{error}");
        };
        check("atas.TickInputs.v1", bytes(), TickInputs::TYPE_NAME);
        check(
            "atas.TickInputs.v999",
            bytes(),
            "use the version that recorded it",
        );
        let mut short = bytes();
        short.pop();
        check(TickInputs::TYPE_NAME, short, "the file is damaged");
    }
}
