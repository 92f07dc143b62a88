//! Tactile frames of a recorded run, of both hands, in the order in which the daemon received them.

// Numbers of a file or a device reach this arithmetic.
#![warn(clippy::arithmetic_side_effects)]

use std::collections::VecDeque;
use std::path::PathBuf;

use anyhow::bail;
use shm_schemas::{Hand, HandFrame, TickInputs};

use crate::reader::{Entry, Reader, payload};

/// Tactile frame of a run.
#[derive(Clone, Copy, Debug)]
pub struct RecordedFrame {
    /// Time of the run's first tick, sensor time, ns.
    pub begun_ns: u64,
    /// Hand of the frame.
    pub hand: Hand,
    /// Frame as received, not validated.
    pub frame: HandFrame,
}

/// Iterator over frames. A read error is its last item.
pub struct Frames {
    files: VecDeque<PathBuf>,
    name: String,
    entries: Option<Reader>,
    begun_ns: Option<u64>,
    /// Frames of the last part read.
    waiting: VecDeque<RecordedFrame>,
    has_ended: bool,
}

impl Frames {
    /// Creates the iterator for the files of one run, in order.
    #[must_use]
    pub fn open(files: &[PathBuf]) -> Self {
        Self {
            files: files.iter().cloned().collect(),
            name: files
                .first()
                .map_or_else(String::new, |file| file.display().to_string()),
            entries: None,
            begun_ns: None,
            waiting: VecDeque::new(),
            has_ended: false,
        }
    }

    fn read(&mut self) -> anyhow::Result<Option<RecordedFrame>> {
        loop {
            if let Some(measured) = self.waiting.pop_front() {
                return Ok(Some(measured));
            }
            let Some(entries) = &mut self.entries else {
                match self.files.pop_front() {
                    Some(file) => self.entries = Some(Reader::open(&file)?),
                    None if self.begun_ns.is_some() => return Ok(None),
                    None => bail!(
                        "could not find what came in in {}; record a daemon that says so: `atas record`, then \
                         `atasd --record-stream`",
                        self.name
                    ),
                }
                continue;
            };
            match entries.next().transpose()? {
                None => self.entries = None,
                Some(Entry::Metadata(_)) => {}
                Some(Entry::Message(message)) => {
                    if let Some(part) = payload::<TickInputs>(&message)? {
                        self.take(&part);
                    }
                }
            }
        }
    }

    fn take(&mut self, part: &TickInputs) {
        let begun_ns = *self.begun_ns.get_or_insert(part.stamp.captured_ns);
        let hands = [Hand::LEFT, Hand::RIGHT].into_iter();
        for (hand, (has_frame, frame)) in hands.zip(part.has_frame.iter().zip(&part.frames)) {
            if *has_frame != 0 {
                self.waiting.push_back(RecordedFrame {
                    begun_ns,
                    hand,
                    frame: *frame,
                });
            }
        }
    }
}

impl Iterator for Frames {
    type Item = anyhow::Result<RecordedFrame>;

    fn next(&mut self) -> Option<Self::Item> {
        if self.has_ended {
            return None;
        }
        let next = self.read().transpose();
        self.has_ended = !matches!(next, Some(Ok(_)));
        next
    }
}
