//! Replay: runs the production controller on the recorded inputs of a run.

use std::path::PathBuf;

use anyhow::Context;
use atas_core::Controller;
use atas_core::record::{Replay, Replayed, read_origin};
use atas_recording::{Entry, Reader, command_difference, origin, payload, state};
use robot_model::RobotFiles;
use shm_schemas::capacity::HANDS;
use shm_schemas::{HandFrame, RunHeader, TickInputs};

/// Buffer size for the frames of one hand in one tick, above the daemon's intake limit.
const FRAMES: usize = 256;

/// Comparison of a replay with its recording.
#[derive(Debug, Default)]
pub struct ReplayComparison {
    /// Number of ticks replayed.
    pub ticks: u64,
    /// First tick with a different command, and the differing field.
    pub first_difference: Option<(u64, String)>,
    /// Number of ticks with a different command.
    pub different: u64,
    /// Version of the controller that was recorded.
    pub recorded_version: String,
}

/// Replays the files of one run in order, from the first tick or a saved state. Calls `each` per
/// tick with recorded inputs and replayed outputs.
///
/// # Errors
/// A file cannot be read or replayed.
pub fn replay(
    files: &[PathBuf],
    mut each: impl FnMut(&TickInputs, &Replayed<'_>),
) -> anyhow::Result<ReplayComparison> {
    let mut agreement = ReplayComparison::default();
    let mut replay = None::<Replay<Vec<HandFrame>>>;
    // Header of the first file, and the saved state if it is a continuation file.
    let (mut header, mut begin, mut robot) = (None, None, None);
    let readers: Result<Vec<Reader>, _> = files.iter().map(|file| Reader::open(file)).collect();
    for entry in readers?.into_iter().flatten() {
        let message = match entry? {
            Entry::Message(message) => message,
            Entry::Metadata(metadata) => {
                robot = origin::robot_from_metadata(&metadata).or(robot);
                continue;
            }
        };
        if replay.is_none() {
            begin = state(&message).map(<[u8]>::to_vec).or(begin);
            header = payload::<RunHeader>(&message)?.or(header);
        }
        let Some(part) = payload::<TickInputs>(&message)? else {
            continue;
        };
        let replay = match &mut replay {
            Some(replay) => replay,
            none => none.insert(start(header.as_deref(), robot.as_ref(), begin.as_deref())?),
        };
        if let Some(header) = &header {
            agreement.recorded_version = header.version.to_string();
        }
        if let Some(replayed) = replay.feed(&part)? {
            each(&part, &replayed);
            agreement.update(&part, &replayed);
        }
    }
    Ok(agreement)
}

fn start(
    header: Option<&RunHeader>,
    carried: Option<&RobotFiles>,
    begin: Option<&[u8]>,
) -> anyhow::Result<Replay<Vec<HandFrame>>> {
    let header = header.context("could not replay: the file has no run header before its ticks")?;
    let Some(state) = begin else {
        return Ok(Replay::new(
            initial_controller(header, carried)?,
            frame_buffers(),
        ));
    };
    let (controller, next_sequence) = atas_controller_state::decode(state)?;
    Ok(Replay::resume(controller, next_sequence, frame_buffers()))
}

/// Returns the initial controller for the recorded robot, else the one named in the header.
pub(crate) fn initial_controller(
    header: &RunHeader,
    carried: Option<&RobotFiles>,
) -> anyhow::Result<Controller> {
    let robot = origin::robot(Some(header), carried)?
        .load()
        .with_context(|| format!("could not load the robot {}", header.robot))?;
    Ok(read_origin(header, &robot)?)
}

pub(crate) fn frame_buffers() -> [Vec<HandFrame>; HANDS] {
    [(); HANDS].map(|()| vec![HandFrame::default(); FRAMES])
}

impl ReplayComparison {
    fn update(&mut self, part: &TickInputs, replayed: &Replayed<'_>) {
        self.ticks += 1;
        if !replayed.is_equal {
            self.different += 1;
            let field = || command_difference(&part.command, &replayed.outputs.command, &[]);
            self.first_difference
                .get_or_insert_with(|| (part.tick, field().unwrap_or_else(|| "padding".into())));
        }
    }
}
