//! Rows of a recording: all streams joined, one row per tick.
//!
//! * **Input:** files of one run, in order. **Outputs:** rows in the order of their ticks; the run
//!   header; the clock that converts sensor time to wall-clock time.
//! * **Invariants:** memory is bounded. A row contains only data recorded in its tick: a hand
//!   without a new frame has none.

// Numbers of a file or a device reach this arithmetic.
#![warn(clippy::arithmetic_side_effects)]

use std::collections::{BTreeMap, VecDeque};
use std::path::{Path, PathBuf};

use anyhow::Context;
use atas_client::goal_summary::begins;
use mcap::records::Metadata;
use robot_model::RobotFiles;
use shm_schemas::capacity::HANDS;
use shm_schemas::{
    EventKind, GoalRequest, GraspTarget, HandFrame, JointCommand, JointState, ModuleEvent,
    OrderKind, RunHeader, Status, StatusFlags, Text, TickInputs, TickReport,
};

use crate::clock::Clock;
use crate::origin::robot_from_metadata;
use crate::reader::{Entry, Reader, payload};

/// Number of ticks that wait for late data: the recorder polls one stream after another, a
/// millisecond apart. Design choice: a second at 1 kHz.
const WAITING: usize = 1024;

/// Data of one tick.
#[derive(Debug, Default)]
pub struct Row {
    /// Index of the tick.
    pub tick: u64,
    /// Sensor time of the tick, ns.
    pub captured_ns: u64,
    /// Report of the tick.
    pub report: Option<Box<TickReport>>,
    /// Inputs and command; `None` unless the daemon ran with `--record-stream`.
    pub inputs: Option<Box<RowInputs>>,
    /// Events of the tick.
    pub events: Vec<ModuleEvent>,
    /// Name of each hand's step during a goal, from the events so far; empty without a goal.
    pub steps: [Text<16>; HANDS],
}

/// Inputs and command of a tick.
#[derive(Debug, Default)]
pub struct RowInputs {
    /// Newest frame of each hand, if one arrived.
    pub frames: [Option<HandFrame>; HANDS],
    /// Joint state, if one arrived.
    pub joints: Option<JointState>,
    /// Newest target of teleoperation for each hand, if one arrived.
    pub target: [Option<GraspTarget>; HANDS],
    /// Goal request, if there was one.
    pub goal: Option<GoalRequest>,
    /// Published command.
    pub command: JointCommand,
}

/// Rows of a run.
pub struct Rows {
    files: VecDeque<PathBuf>,
    entries: Reader,
    waiting: BTreeMap<u64, Row>,
    header: Option<Box<RunHeader>>,
    robot: Option<RobotFiles>,
    clock: Clock,
    goal_statuses: Vec<Status>,
    has_ended: bool,
    /// Steps after the last returned row.
    steps: [Text<16>; HANDS],
}

impl Rows {
    /// Opens the files of one run and reads up to the first tick.
    ///
    /// # Errors
    /// The first file cannot be opened or is damaged before its first tick, or no file contains a
    /// tick.
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
            goal_statuses: Vec::new(),
            has_ended: false,
            steps: [Text::default(); HANDS],
        };
        while rows.waiting.is_empty() && rows.take_entry()? {}
        let first_ns = rows.waiting.values().next().map(|row| row.captured_ns);
        let first_ns = first_ns.with_context(|| no_tick_error(&first))?;
        let is_virtual = rows
            .header()
            .is_some_and(|h| h.flags & StatusFlags::LOCKSTEP != 0);
        rows.clock.set_offset(first_ns, is_virtual);
        Ok(rows)
    }

    /// Returns the run header, if recorded.
    #[must_use]
    pub fn header(&self) -> Option<&RunHeader> {
        self.header.as_deref()
    }

    /// Returns the robot's files, if the recording contains them.
    #[must_use]
    pub fn robot(&self) -> Option<&RobotFiles> {
        self.robot.as_ref()
    }

    /// Returns the conversion from sensor time to wall-clock time.
    #[must_use]
    pub fn clock(&self) -> Clock {
        self.clock
    }

    /// Returns, for each goal read so far, the first status that contains it.
    #[must_use]
    pub fn goal_statuses(&self) -> &[Status] {
        &self.goal_statuses
    }

    /// Reads one entry; returns false at the end of the last file.
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
            // The bus keeps old events for late readers. Events of unrecorded ticks have no row.
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
            let last_id = self
                .goal_statuses
                .last()
                .map_or(0, |reported| reported.goal_id);
            if status.goal_id != last_id && status.goal_id != 0 {
                self.goal_statuses.push(*status);
            }
        }
        Ok(())
    }

    fn take_metadata(&mut self, metadata: &Metadata) {
        if metadata.name == crate::rotation::ORIGIN {
            self.clock.read_metadata(&metadata.metadata);
        }
        if let Some(robot) = robot_from_metadata(metadata) {
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
        let hand = part.target.hand.index();
        if let Some(target) = hand.and_then(|hand| inputs.target.get_mut(hand))
            && part.has_target != 0
        {
            *target = Some(part.target);
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
        let (_, mut row) = self.waiting.pop_first()?;
        for event in &row.events {
            update_steps(&mut self.steps, event);
        }
        row.steps = self.steps;
        Some(Ok(row))
    }
}

/// Updates the step names with an event. The first step is reported before its goal runs.
fn update_steps(steps: &mut [Text<16>; HANDS], event: &ModuleEvent) {
    match event.kind {
        EventKind::STEP => {
            if let Some(step) = event.hand.index().and_then(|hand| steps.get_mut(hand)) {
                *step = event.text;
            }
        }
        EventKind::GOAL if !begins(event) => *steps = Default::default(),
        _ => {}
    }
}

fn no_tick_error(path: &Path) -> String {
    format!(
        "could not find a tick in {}; start `atas record` first, then `atasd --record-stream`",
        path.display()
    )
}
