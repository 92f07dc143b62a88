//! MCAP file of the profile `ros2`, for public viewers. [`super::messages`] lists its contents.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::BufWriter;

use mcap::records::MessageHeader;
use mcap::{Compression, WriteOptions};

use super::Sink;
use super::messages::{Messages, Outlet};
use super::ros::MessageType;
use super::subject::Subject;
use crate::rows::Row;

/// Level of zstd. Design choice: the fastest.
const LEVEL: u32 = 1;

/// MCAP file.
pub(super) struct Mcap(Messages<Channels>);

/// Channels of the file.
struct Channels(mcap::Writer<BufWriter<File>>);

impl Mcap {
    pub(super) fn new(
        file: BufWriter<File>,
        subject: Subject,
        pictures_hz: f64,
    ) -> anyhow::Result<Self> {
        let options = WriteOptions::new()
            .profile("ros2")
            .library(concat!("atas ", env!("CARGO_PKG_VERSION")))
            .compression(Some(Compression::Zstd))
            .compression_level(LEVEL)
            // In this thread: handing small blocks to another thread costs more than compressing
            // them.
            .compression_threads(0);
        let mut mcap = options.create(file)?;
        let made_by = subject.made_by.iter();
        mcap.write_metadata(&mcap::records::Metadata {
            name: crate::rotation::ORIGIN.to_owned(),
            metadata: made_by.map(|(k, v)| ((*k).to_owned(), v.clone())).collect(),
        })?;
        Ok(Self(Messages::new(Channels(mcap), subject, pictures_hz)))
    }
}

impl Outlet for Channels {
    fn open(&mut self, topic: &str, of: &MessageType, unit: &str) -> anyhow::Result<u16> {
        let schema = self
            .0
            .add_schema(of.name, MessageType::LANGUAGE, of.schema().as_bytes())?;
        let unit = (!unit.is_empty()).then(|| ("unit".to_owned(), unit.to_owned()));
        let described = unit.into_iter().collect::<BTreeMap<_, _>>();
        let encoding = MessageType::ENCODING;
        Ok(self.0.add_channel(schema, topic, encoding, &described)?)
    }

    fn send(&mut self, channel_id: u16, unix_ns: u64, cdr: &[u8]) -> anyhow::Result<()> {
        let header = MessageHeader {
            channel_id,
            sequence: 0,
            log_time: unix_ns,
            publish_time: unix_ns,
        };
        self.0.write_to_known_channel(&header, cdr)?;
        Ok(())
    }
}

impl Sink for Mcap {
    fn row(&mut self, row: &Row) -> anyhow::Result<()> {
        self.0.row(row)
    }

    fn finish(self: Box<Self>) -> anyhow::Result<()> {
        self.0.into_outlet().0.finish()?;
        Ok(())
    }
}
