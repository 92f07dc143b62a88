//! A recording as one row per tick: what its streams have of the tick, joined.
//!
//! * **In:** the files of one run, in order. **Out:** rows in the order of their ticks; beside them how the run began, and
//!   the clock that turns sensor time into wall-clock time.
//! * **Invariants:** memory is bounded. A row has what was recorded of its tick and nothing else: a hand without a new frame
//!   has none.

use std::collections::{BTreeMap, VecDeque};
use std::path::{Path, PathBuf};

use anyhow::Context;
use mcap::records::Metadata;
use robot_model::RobotFiles;
use shm_schemas::capacity::HANDS;
use shm_schemas::{
    GoalRequest, HandFrame, JointCommand, JointState, ModuleEvent, OrderKind, RunHeader, Status,
    StatusFlags, TickInputs, TickReport,
};

use crate::clock::Clock;
use crate::origin::carried_robot;
use crate::reader::{Entry, Reader, payload};

/// Ticks that may wait for the rest of what is known of them: the recorder looks at one stream after another, a
/// millisecond apart (ours: a second at 1 kHz).
const WAITING: usize = 1024;

/// What one tick was and did.
#[derive(Debug, Default)]
pub struct Row {
    /// Index of the tick.
    pub tick: u64,
    /// Its time, sensor time, ns.
    pub captured_ns: u64,
    /// What it made of what came in.
    pub report: Option<Box<TickReport>>,
    /// What came in and what went out; `None` unless the daemon ran with `--record-stream`.
    pub inputs: Option<Box<RowInputs>>,
    /// What happened in it.
    pub events: Vec<ModuleEvent>,
}

/// What came in and what went out.
#[derive(Debug, Default)]
pub struct RowInputs {
    /// The newest frame of each hand, if one came.
    pub frames: [Option<HandFrame>; HANDS],
    /// The joint state, if one came.
    pub joints: Option<JointState>,
    /// The goal that was asked for, if one was.
    pub goal: Option<GoalRequest>,
    /// The command.
    pub command: JointCommand,
}

/// The rows of a run.
pub struct Rows {
    files: VecDeque<PathBuf>,
    entries: Reader,
    waiting: BTreeMap<u64, Row>,
    header: Option<Box<RunHeader>>,
    robot: Option<RobotFiles>,
    clock: Clock,
    told_goals: Vec<Status>,
    has_ended: bool,
}

impl Rows {
    /// Opens the files of one run and reads as far as the first tick.
    ///
    /// # Errors
    /// The first file cannot be opened or is damaged before its first tick, or there is no tick in any of them.
    pub fn open(files: &[PathBuf]) -> anyhow::Result<Self> {
        let mut files: VecDeque<PathBuf> = files.iter().cloned().collect();
        let first = files.pop_front().context("no recording was named")?;
        let mut rows = Self {
            files,
            entries: Reader::open(&first)?,
            waiting: BTreeMap::new(),
            header: None,
            robot: None,
            clock: Clock::default(),
            told_goals: Vec::new(),
            has_ended: false,
        };
        while rows.waiting.is_empty() && rows.take_entry()? {}
        let first_ns = rows.waiting.values().next().map(|row| row.captured_ns);
        let first_ns = first_ns.with_context(|| nothing_in(&first))?;
        let is_virtual = rows
            .header()
            .is_some_and(|h| h.flags & StatusFlags::LOCKSTEP != 0);
        rows.clock.settle(first_ns, is_virtual);
        Ok(rows)
    }

    /// How the run began; `None` if nobody said so.
    #[must_use]
    pub fn header(&self) -> Option<&RunHeader> {
        self.header.as_deref()
    }

    /// The robot's files, if the recording carries them.
    #[must_use]
    pub fn robot(&self) -> Option<&RobotFiles> {
        self.robot.as_ref()
    }

    /// From sensor time to wall-clock time.
    #[must_use]
    pub fn clock(&self) -> Clock {
        self.clock
    }

    /// Of each goal that was read of so far the first status that tells of it.
    #[must_use]
    pub fn told_goals(&self) -> &[Status] {
        &self.told_goals
    }

    /// Reads on by one entry; false at the end of the last file.
    fn take_entry(&mut self) -> anyhow::Result<bool> {
        match self.entries.next().transpose()? {
            Some(Entry::Message(message)) => self.take_message(&message)?,
            Some(Entry::Metadata(metadata)) => self.take_metadata(&metadata),
            None => match self.files.pop_front() {
                Some(next) => self.entries = Reader::open(&next)?,
                None => return Ok(false),
            },
        }
        Ok(true)
    }

    fn take_message(&mut self, message: &mcap::Message<'_>) -> anyhow::Result<()> {
        if let Some(part) = payload::<TickInputs>(message)? {
            self.row(part.tick, part.stamp.captured_ns)
                .add_inputs(&part);
        } else if let Some(report) = payload::<TickReport>(message)? {
            let row = self.row(report.tick, report.stamp.captured_ns);
            row.report = Some(report);
        } else if let Some(event) = payload::<ModuleEvent>(message)? {
            // The bus keeps old events for who comes late; those of ticks that are not recorded have no row.
            if self
                .waiting
                .first_key_value()
                .is_some_and(|(first, _)| *first <= event.tick)
            {
                self.row(event.tick, event.stamp.captured_ns)
                    .events
                    .push(*event);
            }
        } else if let Some(header) = payload::<RunHeader>(message)? {
            self.header.get_or_insert(header);
        } else if let Some(status) = payload::<Status>(message)? {
            let last_id = self.told_goals.last().map_or(0, |told| told.goal_id);
            if status.goal_id != last_id && status.goal_id != 0 {
                self.told_goals.push(*status);
            }
        }
        Ok(())
    }

    fn take_metadata(&mut self, metadata: &Metadata) {
        if metadata.name == crate::rotation::ORIGIN {
            self.clock.learn(&metadata.metadata);
        }
        if let Some(robot) = carried_robot(metadata) {
            self.robot = Some(robot);
        }
    }

    fn row(&mut self, tick: u64, captured_ns: u64) -> &mut Row {
        self.waiting.entry(tick).or_insert_with(|| Row {
            tick,
            captured_ns,
            ..Row::default()
        })
    }
}

impl Row {
    fn add_inputs(&mut self, part: &TickInputs) {
        let inputs = self.inputs.get_or_insert_default();
        for (hand, frame) in inputs.frames.iter_mut().enumerate() {
            if part.has_frame[hand] != 0 {
                *frame = Some(part.frames[hand]);
            }
        }
        if part.has_joints != 0 {
            inputs.joints = Some(part.joints);
        }
        if part.order.kind == OrderKind::START {
            inputs.goal = Some(part.order.goal);
        }
        inputs.command = part.command;
    }
}

impl Iterator for Rows {
    type Item = anyhow::Result<Row>;

    fn next(&mut self) -> Option<Self::Item> {
        while !self.has_ended && self.waiting.len() <= WAITING {
            match self.take_entry() {
                Ok(goes_on) => self.has_ended = !goes_on,
                Err(error) => {
                    self.has_ended = true;
                    self.waiting.clear();
                    return Some(Err(error));
                }
            }
        }
        self.waiting.pop_first().map(|(_, row)| Ok(row))
    }
}

fn nothing_in(path: &Path) -> String {
    format!(
        "could not find a tick in {}; record a daemon that ticks: `atas record`, then `atasd --record-stream`",
        path.display()
    )
}
