//! Recording prepared for random access by the page.
//!
//! The number of pictures is bounded; the picture rate decreases with the length of the recording.

use std::array;
use std::path::PathBuf;

use anyhow::Context;
use atas_client::layouts;
use atas_recording::{Row, Rows, origin};
use robot_model::HandSide;
use serde_json::{Value, json};
use shm_schemas::capacity::HANDS;
use shm_schemas::{HandFrame, JointState, TickReport};

use crate::displayed::DisplayedRobot;
use crate::faults::Faults;
use crate::feed::moment;
use crate::observe::event_json;
use crate::picture::Picture;

/// Most stored pictures of about 6 KiB (design choice: 40 MiB, 100 s at 60 Hz).
const PICTURES: usize = 6000;
const RATE_HZ: f64 = 60.0;
const EVENTS: usize = 20_000;

pub(crate) struct LoadedRecording {
    pictures: Vec<String>,
    moments: Vec<Vec<f64>>,
    events: Vec<Value>,
    period_s: f64,
    /// Fingertips with sensors, per hand.
    fingers: [usize; HANDS],
    pub(crate) faults: Faults,
    pub(crate) scene: Value,
    name: String,
}

impl LoadedRecording {
    /// Reads the files of one run.
    ///
    /// # Errors
    /// A file cannot be read to its end.
    pub(crate) fn read(files: &[PathBuf]) -> anyhow::Result<Self> {
        let seconds = length_s(files)?;
        let rows = Rows::open(files)?;
        let shown = recorded_robot(&rows)?;
        let counts = shown.layouts.each_ref().map(|layout| layout.count);
        let mut shelf = Self {
            pictures: Vec::new(),
            moments: Vec::new(),
            events: Vec::new(),
            period_s: (seconds / PICTURES as f64).max(1.0 / RATE_HZ),
            faults: Faults::default(),
            fingers: shown.fingers,
            scene: crate::scene::scene(&shown).context("could not load the recorded robot")?,
            name: files[0].display().to_string(),
        };
        let mut now = LastInputs::default();
        let mut next_ns = 0;
        for row in rows {
            let row = row?;
            now.update(&row);
            shelf.add_events(&row);
            if let Some(report) = row.report.as_deref()
                && row.captured_ns >= next_ns
            {
                next_ns = row
                    .captured_ns
                    .saturating_add((shelf.period_s * 1e9) as u64);
                shelf.add_picture(report, &now, counts)?;
            }
        }
        anyhow::ensure!(
            !shelf.pictures.is_empty(),
            "could not find a tick report in {}; select a recording of `atas record`",
            shelf.name
        );
        Ok(shelf)
    }

    fn add_picture(
        &mut self,
        report: &TickReport,
        now: &LastInputs,
        counts: [usize; 2],
    ) -> anyhow::Result<()> {
        let frames = now.frames.each_ref().map(Option::as_ref);
        let joints = now.joints.as_ref();
        let picture = Picture::from_report(report, frames, joints, self.fingers, counts);
        self.pictures.push(serde_json::to_string(&picture)?);
        self.moments.push(moment(report).to_vec());
        Ok(())
    }

    fn add_events(&mut self, row: &Row) {
        let report = row.report.as_deref();
        if let Some(report) = report {
            self.faults.store_report(report);
        }
        for event in &row.events {
            if self.events.len() < EVENTS {
                self.events.push(event_json(event, report, self.fingers));
            }
            self.faults.process_event(event);
        }
    }

    pub(crate) fn to_json(&self) -> Value {
        json!({
            "name": self.name,
            "count": self.pictures.len(),
            "period_s": self.period_s,
            "moments": self.moments,
            "events": self.events,
            "faults": self.faults.list(),
        })
    }

    /// Returns `count` pictures from index `from`, as a JSON list.
    pub(crate) fn pictures(&self, from: usize, count: usize) -> String {
        let end = from.saturating_add(count).min(self.pictures.len());
        let found = self.pictures.get(from..end).unwrap_or_default();
        format!("[{}]", found.join(","))
    }
}

/// Returns the recorded robot: existing hands with their recorded fingertips.
fn recorded_robot(rows: &Rows) -> anyhow::Result<DisplayedRobot> {
    let robot = origin::robot(rows.header(), rows.robot())?;
    let known = robot.load().context("could not load the recorded robot")?;
    let sensed = origin::fingers(rows.header());
    let is_there = HandSide::BOTH.map(|side| known.hand(side).is_present());
    Ok(DisplayedRobot {
        robot: Some(robot),
        note: String::new(),
        layouts: layouts::of_run(rows.header()),
        fingers: array::from_fn(|hand| if is_there[hand] { sensed[hand] } else { 0 }),
    })
}

#[derive(Default)]
struct LastInputs {
    frames: [Option<HandFrame>; 2],
    joints: Option<JointState>,
}

impl LastInputs {
    fn update(&mut self, row: &Row) {
        let Some(inputs) = row.inputs.as_deref() else {
            return;
        };
        for (known, frame) in self.frames.iter_mut().zip(&inputs.frames) {
            *known = frame.or(*known);
        }
        self.joints = inputs.joints.or(self.joints);
    }
}

fn length_s(files: &[PathBuf]) -> anyhow::Result<f64> {
    let mut ends = None::<(u64, u64)>;
    for row in Rows::open(files)? {
        let at_ns = row?.captured_ns;
        let (first_ns, _) = *ends.get_or_insert((at_ns, at_ns));
        ends = Some((first_ns, at_ns));
    }
    Ok(ends.map_or(0.0, |(first_ns, last_ns)| {
        last_ns.saturating_sub(first_ns) as f64 * 1e-9
    }))
}
