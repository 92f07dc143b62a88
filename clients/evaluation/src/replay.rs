//! The production controller on the recorded inputs of a run.

use std::path::PathBuf;

use anyhow::Context;
use atas_core::record::{Replay, Replayed, read_origin};
use atas_recording::{Entry, Reader, command_difference, origin, payload};
use robot_model::RobotModel;
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

/// Replays the files of one run, in order; `each` sees every tick, as it was recorded and as it is now.
///
/// # Errors
/// A file cannot be read, or not be replayed.
pub fn replay(
    files: &[PathBuf],
    mut each: impl FnMut(&TickInputs, &Replayed<'_>),
) -> anyhow::Result<Agreement> {
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
            if let Some(replayed) = replay.feed(&part)? {
                each(&part, &replayed);
                agreement.take(&part, &replayed);
            }
        }
    }
    Ok(agreement)
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

/// The robot that the header names.
fn robot(header: &RunHeader) -> anyhow::Result<RobotModel> {
    let urdf = origin::urdf(Some(header))?;
    RobotModel::from_urdf(&urdf)
        .with_context(|| format!("could not load the robot {}", header.robot))
}
