//! The production controller on the recorded inputs of a run.

use std::path::PathBuf;

use anyhow::Context;
use atas_core::Controller;
use atas_core::record::{Replay, Replayed, read_origin};
use atas_recording::{Entry, Reader, command_difference, origin, payload, state};
use robot_model::RobotFiles;
use shm_schemas::capacity::HANDS;
use shm_schemas::{HandFrame, RunHeader, TickInputs};

/// Frames of one hand that one tick can have taken: what the daemon's intake takes at most, with room.
const FRAMES: usize = 256;

/// How far the replay agreed.
#[derive(Debug, Default)]
pub struct Agreement {
    /// Ticks replayed.
    pub ticks: u64,
    /// The first tick whose command differs, and in what.
    pub first: Option<(u64, String)>,
    /// Ticks whose command differs.
    pub different: u64,
}

/// Replays the files of one run, in order, from the run's first tick or from the state that the first of them begins with; `each` sees every tick, as it was recorded and as it is now.
///
/// # Errors
/// A file cannot be read, or not be replayed.
pub fn replay(
    files: &[PathBuf],
    mut each: impl FnMut(&TickInputs, &Replayed<'_>),
) -> anyhow::Result<Agreement> {
    let mut agreement = Agreement::default();
    let mut replay = None::<Replay<Vec<HandFrame>>>;
    // The header of the first file and the state at its beginning, if it goes on with a run.
    let (mut header, mut begin, mut robot) = (None, None, None);
    let readers: Result<Vec<Reader>, _> = files.iter().map(|file| Reader::open(file)).collect();
    for entry in readers?.into_iter().flatten() {
        let message = match entry? {
            Entry::Message(message) => message,
            Entry::Metadata(metadata) => {
                robot = origin::carried_robot(&metadata).or(robot);
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
            none => none.insert(begin_at(
                header.as_deref(),
                robot.as_ref(),
                begin.as_deref(),
            )?),
        };
        if let Some(replayed) = replay.feed(&part)? {
            each(&part, &replayed);
            agreement.take(&part, &replayed);
        }
    }
    Ok(agreement)
}

/// A replay from the beginning of a run, or from a state.
fn begin_at(
    header: Option<&RunHeader>,
    carried: Option<&RobotFiles>,
    begin: Option<&[u8]>,
) -> anyhow::Result<Replay<Vec<HandFrame>>> {
    let header =
        header.context("could not replay because the file has no run header before its ticks")?;
    let Some(state) = begin else {
        return Ok(Replay::new(first(header, carried)?, frames()));
    };
    let (controller, next_sequence) = crate::state::decode(state)?;
    Ok(Replay::resume(controller, next_sequence, frames()))
}

/// The controller that the run began with, of the robot that the recording carries, else of the one that the header names.
pub(crate) fn first(
    header: &RunHeader,
    carried: Option<&RobotFiles>,
) -> anyhow::Result<Controller> {
    let robot = origin::robot(Some(header), carried)?
        .load()
        .with_context(|| format!("could not load the robot {}", header.robot))?;
    Ok(read_origin(header, &robot)?)
}

/// Room for the frames of one tick.
pub(crate) fn frames() -> [Vec<HandFrame>; HANDS] {
    [(); HANDS].map(|()| vec![HandFrame::default(); FRAMES])
}

impl Agreement {
    fn take(&mut self, part: &TickInputs, replayed: &Replayed<'_>) {
        self.ticks += 1;
        if !replayed.is_equal {
            self.different += 1;
            let field = || command_difference(&part.command, &replayed.outputs.command, &[]);
            self.first
                .get_or_insert_with(|| (part.tick, field().unwrap_or_else(|| "padding".into())));
        }
    }
}
