//! Data set of LeRobot (format v3.0): one episode per goal of the recorded runs.
//!
//! ```text
//!  Rows ─▶ Episodes (goals, frames at fps) ─▶ Writer ─▶ data/*.parquet, meta/{info,stats}.json,
//!                                                       meta/tasks.parquet, meta/episodes/*
//! ```
//!
//! | column | contents |
//! |---|---|
//! | `observation.state` | pinch pose, joints, tactile summary, grip force limits, modules |
//! | `observation.environment_state` | expected object and place of the goal; zero if unknown |
//! | `observation.taxels` | with `elements`: force components of all sensor elements, N |
//! | `action` | target of a teleoperated hand, else commanded pinch pose, one frame later |
//! | `next.done`, `next.success` | end of the episode; true if the goal succeeded |
//!
//! * **Invariants:** frames of an episode are 1/fps apart in recorded time. A value that no tick
//!   updates keeps its last value; lost ticks repeat frames. Statistics are exact, over all frames.
//! * **Not included:** videos; goals that only release; goals of the other hand, which are counted.

mod columns;
mod draft_folder;
mod episode;
mod features;
mod run;
mod statistics;
mod writer;

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};

use anyhow::Context;
use atas_client::layouts;
use robot_model::HandSide;
use shm_schemas::{GoalKind, Hand};

use crate::origin;
use crate::rows::Rows;
use crate::runs::runs;
use draft_folder::DraftFolder;
use features::Features;
use run::Run;
use writer::Writer;

/// Ticks per second of the daemon.
const TICK_HZ: u32 = 1000;

/// Options of the export.
#[derive(Clone, Debug)]
pub struct DatasetChoices {
    /// Frames per second; divides 1000.
    pub fps: u32,
    /// Hand; default: that of the first goal.
    pub hand: Option<Hand>,
    /// Task text; default: a sentence per kind of goal.
    pub task: Option<String>,
    /// True to add the forces of all sensor elements.
    pub elements: bool,
}

/// Summary of an export.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Dataset {
    /// Episodes.
    pub episodes: usize,
    /// Episodes whose goal succeeded.
    pub successes: usize,
    /// Frames of all episodes.
    pub frames: usize,
    /// Goals left out: of the other hand, or without a frame.
    pub skipped: usize,
}

/// Exports recordings of one or several runs into a new folder, until the end or until `stop` is
/// set.
///
/// # Errors
/// A recording cannot be read to its end, has no goal or no joint states, or the folder cannot be
/// written. No folder is created then.
pub fn export_dataset(
    files: &[PathBuf],
    out: &Path,
    choices: &DatasetChoices,
    stop: &AtomicBool,
) -> anyhow::Result<Dataset> {
    anyhow::ensure!(
        choices.fps > 0 && TICK_HZ.is_multiple_of(choices.fps),
        "could not export: {} frames per second do not divide the {TICK_HZ} ticks per second; use \
         for example 20, 50 or 100",
        choices.fps
    );
    let draft = DraftFolder::next_to(out)?;
    let mut writer = Writer::new(draft.path.clone(), choices.fps);
    for run in runs(files)? {
        export_run(&run, choices, &mut writer, stop)
            .with_context(|| format!("could not export {}", run[0].display()))?;
        if stop.load(Ordering::Relaxed) {
            break;
        }
    }
    let dataset = writer.finish().context("could not export")?;
    draft.publish()?;
    Ok(dataset)
}

fn export_run(
    files: &[PathBuf],
    choices: &DatasetChoices,
    writer: &mut Writer,
    stop: &AtomicBool,
) -> anyhow::Result<()> {
    let rows = Rows::open(files)?;
    let robot = origin::robot(rows.header(), rows.robot())?;
    let robot = robot.load().context("could not load the recorded robot")?;
    let fingers = origin::fingers(rows.header());
    let layouts = layouts::of_run(rows.header());
    let mut state: Option<Run> = None;
    let mut has_inputs = false;
    for row in rows {
        let row = row?;
        if stop.load(Ordering::Relaxed) {
            break;
        }
        has_inputs |= row.inputs.is_some();
        let goal = row.inputs.as_deref().and_then(|inputs| inputs.goal);
        if state.is_none() {
            let Some(goal) = goal.filter(|goal| goal.kind != GoalKind::RELEASE) else {
                continue;
            };
            let hand = writer.hand.or(choices.hand).unwrap_or(goal.hand);
            writer.hand = Some(hand);
            let side = HandSide::BOTH[usize::from(hand != Hand::LEFT)];
            anyhow::ensure!(
                robot.hand(side).is_present(),
                "the recorded robot has no {hand} hand; choose the other one with --hand"
            );
            let elements = if choices.elements {
                layouts[side.index()].count
            } else {
                0
            };
            let count = fingers[side.index()].min(robot.hand(side).fingertip_count());
            let features = Features::new(robot.clone(), side, count, elements);
            writer.use_features(&features)?;
            state = Some(Run::new(features, hand, TICK_HZ / choices.fps));
        }
        if let Some(run) = &mut state {
            run.tick(&row, goal, choices, writer)?;
        }
    }
    anyhow::ensure!(
        has_inputs,
        "it has no joint states and commands; start the daemon with `atasd --record-stream`"
    );
    match &mut state {
        Some(run) => run.end(None, choices, writer),
        None => Ok(()),
    }
}
