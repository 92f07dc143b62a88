//! Reader of one MCAP file, from its beginning, in bounded memory. A truncated or damaged file is
//! read up to the damage; then follows an error.

use std::borrow::Cow;
use std::fs::File;
use std::io::{BufReader, Read};
use std::path::{Path, PathBuf};

use anyhow::Context;
use mcap::Message;
use mcap::read::ChannelAccumulator;
use mcap::records::{Metadata, Record};
use mcap::sans_io::{LinearReadEvent, LinearReader, LinearReaderOptions};

use super::payloads::Recorded;

/// Longest accepted record, bytes: a hundred times a chunk. A damaged length must not exhaust
/// memory.
const RECORD_MAX_BYTES: usize = 128 << 20;

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
        let options = LinearReaderOptions::default()
            .with_validate_chunk_crcs(true)
            .with_prevalidate_chunk_crcs(true)
            .with_validate_data_section_crc(true)
            .with_validate_summary_section_crc(true)
            .with_record_length_limit(RECORD_MAX_BYTES);
        Ok(Self {
            file: BufReader::new(file),
            records: LinearReader::new_with_options(options),
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
        while let Some(event) = self.records.next_event() {
            match event? {
                LinearReadEvent::ReadRequest(bytes) => {
                    let read = self.file.read(self.records.insert(bytes))?;
                    self.records.notify_read(read);
                }
                LinearReadEvent::Record { data, opcode } => {
                    let record = mcap::parse_record(opcode, data)?;
                    if let Some(entry) = entry_of(&mut self.channels, record)? {
                        return Ok(Some(entry));
                    }
                }
            }
        }
        Ok(None)
    }
}

fn entry_of(
    channels: &mut ChannelAccumulator<'static>,
    record: Record<'_>,
) -> mcap::McapResult<Option<Entry>> {
    match record {
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
