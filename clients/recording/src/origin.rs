//! Robot and sensors of a recording, from its header.

use std::borrow::Cow;

use anyhow::Context;
use mcap::records::Metadata;
use robot_model::{RobotFiles, TWO_HAND_ARM};
use shm_schemas::capacity::FINGERS;
use shm_schemas::{HandWiringRecord, RunHeader};

/// Default number of fingertips per hand: as on the robot of the paper.
const DEFAULT_FINGERTIPS: usize = 2;

/// Name of the metadata with the robot's files, so that a recording is complete without them.
const ROBOT: &str = "atas.robot";
const NAME: &str = "name";
const URDF: &str = "urdf";
const ROBOT_FILE: &str = "robot_file";

/// Returns the robot's files as metadata; `None` if they are missing or have changed since the
/// daemon started.
pub(crate) fn robot_metadata(header: &RunHeader) -> Option<Metadata> {
    let files = RobotFiles::find(header.robot.as_str()).ok()?;
    let is_recorded = files.hash() == header.robot_hash;
    let texts = [
        (NAME, files.name),
        (URDF, files.urdf),
        (ROBOT_FILE, files.robot_file),
    ];
    is_recorded.then(|| Metadata {
        name: ROBOT.to_owned(),
        metadata: texts
            .map(|(key, text)| (key.to_owned(), text.into_owned()))
            .into(),
    })
}

/// Returns the robot's files from metadata, if present.
#[must_use]
pub fn robot_from_metadata(metadata: &Metadata) -> Option<RobotFiles> {
    let text = |key: &str| metadata.metadata.get(key).cloned().map(Cow::Owned);
    (metadata.name == ROBOT).then_some(())?;
    Some(RobotFiles {
        name: text(NAME)?,
        urdf: text(URDF)?,
        robot_file: text(ROBOT_FILE)?,
    })
}

/// Returns the files of the recorded robot: those in the recording, else those that the daemon
/// read, else those of the paper's robot.
///
/// # Errors
/// The files cannot be read, or have changed since.
/// They cannot be read, or have changed since.
pub fn robot(
    header: Option<&RunHeader>,
    carried: Option<&RobotFiles>,
) -> anyhow::Result<RobotFiles> {
    let Some(header) = header else {
        return Ok(TWO_HAND_ARM);
    };
    if let Some(files) = carried.filter(|files| files.hash() == header.robot_hash) {
        return Ok(files.clone());
    }
    let name = header.robot.as_str();
    let files = RobotFiles::find(name).with_context(|| {
        format!("could not find the recorded robot {name}; put its files back there")
    })?;
    anyhow::ensure!(
        files.hash() == header.robot_hash,
        "could not use the robot {name} because it changed since the recording; put the recorded files back there"
    );
    Ok(files)
}

/// Returns the number of fingertips with sensors per hand.
#[must_use]
pub fn fingers(header: Option<&RunHeader>) -> [usize; 2] {
    let fingers = |wiring: &HandWiringRecord| (wiring.fingers as usize).min(FINGERS);
    header.map_or([DEFAULT_FINGERTIPS; 2], |header| {
        header.hands.each_ref().map(fingers)
    })
}
