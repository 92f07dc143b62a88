//! `atas replay`: the production controller on the recorded inputs.

use std::path::PathBuf;

use anyhow::Context;
use atas_console::{Ended, Exit, Output};
use atas_core::record::{Replay, read_origin};
use atas_recording::{Entry, Reader, command_difference, payload};
use robot_model::RobotModel;
use serde_json::json;
use shm_schemas::layout::{FNV_OFFSET, fnv1a};
use shm_schemas::{HandFrame, RunHeader, TickInputs};

/// Frames of one hand that one tick can have taken: what the daemon's intake takes at most, with room.
const FRAMES: usize = 256;
/// How the daemon names the robot that is built in.
const BUILT_IN: &str = "built-in";

/// How far the replay agreed.
#[derive(Debug, Default)]
struct Agreement {
    ticks: u64,
    /// The first tick whose command differs, and in what.
    first: Option<(u64, String)>,
    different: u64,
}

/// `atas replay`: the files of one run, in order.
pub(crate) fn replay(files: &[PathBuf], output: &mut Output) -> anyhow::Result<()> {
    let agreement = run(files)?;
    if output.is_json() {
        output.json(&json!({
            "ticks": agreement.ticks,
            "different": agreement.different,
            "first_tick": agreement.first.as_ref().map(|(tick, _)| tick),
            "first_field": agreement.first.as_ref().map(|(_, field)| field),
        }))?;
    } else {
        output.line(format_args!(
            "{} ticks replayed, {} commands differ",
            agreement.ticks, agreement.different
        ))?;
    }
    match agreement.first {
        None if agreement.ticks == 0 => Err(nothing()),
        None => Ok(()),
        Some((tick, field)) => Err(Ended::with(
            Exit::Failed,
            format!("the replay first differs from the recording in tick {tick}: {field}"),
        )),
    }
}

fn nothing() -> anyhow::Error {
    Ended::with(
        Exit::Failed,
        "could not replay because the recording holds no ticks; record a daemon that runs with --record-stream",
    )
}

fn run(files: &[PathBuf]) -> anyhow::Result<Agreement> {
    let mut agreement = Agreement::default();
    let mut left = vec![HandFrame::default(); FRAMES];
    let mut right = left.clone();
    let mut storage = Some([&mut left[..], &mut right[..]]);
    let mut replay = None::<Replay<'_>>;
    let readers: Result<Vec<Reader>, _> = files.iter().map(|file| Reader::open(file)).collect();
    for entry in readers?.into_iter().flatten() {
        let Entry::Message(message) = entry? else {
            continue;
        };
        if let Some(header) = payload::<RunHeader>(&message)?
            && let Some(storage) = storage.take()
        {
            replay = Some(Replay::new(
                read_origin(&header, &robot(&header)?)?,
                storage,
            ));
        }
        if let Some(part) = payload::<TickInputs>(&message)? {
            let replay = replay.as_mut();
            let replay = replay
                .context("could not replay because the file has no run header before its ticks")?;
            agreement.feed(replay, &part)?;
        }
    }
    Ok(agreement)
}

impl Agreement {
    fn feed(&mut self, replay: &mut Replay<'_>, part: &TickInputs) -> anyhow::Result<()> {
        let Some(replayed) = replay.feed(part)? else {
            return Ok(());
        };
        self.ticks += 1;
        if !replayed.is_equal {
            self.different += 1;
            let field = || command_difference(&part.command, &replayed.outputs.command, &[]);
            self.first
                .get_or_insert_with(|| (part.tick, field().unwrap_or_else(|| "padding".into())));
        }
        Ok(())
    }
}

/// The robot that the header names.
fn robot(header: &RunHeader) -> anyhow::Result<RobotModel> {
    let name = header.robot.as_str();
    if name == BUILT_IN {
        return RobotModel::two_hand_arm().context("could not load the built-in robot model");
    }
    let text = std::fs::read_to_string(name).with_context(|| {
        format!("could not read the recorded robot {name}; put its URDF back there")
    })?;
    anyhow::ensure!(
        fnv1a(FNV_OFFSET, text.as_bytes()) == header.robot_hash,
        "could not replay because {name} changed since the recording; put the recorded URDF back there"
    );
    RobotModel::from_urdf(&text).with_context(|| format!("could not load the robot {name}"))
}
