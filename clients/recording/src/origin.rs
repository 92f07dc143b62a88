//! What a recording's header says of the robot and its sensors, ready to compute with.

use anyhow::Context;
use robot_model::{RobotFiles, TWO_HAND_ARM};
use shm_schemas::capacity::{ELEMENTS, FINGERS};
use shm_schemas::layout::robot_hash;
use shm_schemas::{HandWiringRecord, Layout, RunHeader};

/// Fingers of a hand of which nothing is recorded: the paper's robot's.
const USUAL_FINGERS: usize = 2;

/// The files of the recorded robot; the paper's where nothing is recorded of it.
///
/// # Errors
/// They cannot be read, or have changed since.
pub fn robot(header: Option<&RunHeader>) -> anyhow::Result<RobotFiles> {
    let Some(header) = header else {
        return Ok(TWO_HAND_ARM);
    };
    let name = header.robot.as_str();
    let files = RobotFiles::find(name).with_context(|| {
        format!("could not find the recorded robot {name}; put its files back there")
    })?;
    anyhow::ensure!(
        robot_hash(&files.urdf, &files.robot_file) == header.robot_hash,
        "could not use the robot {name} because it changed since the recording; put the recorded files back there"
    );
    Ok(files)
}

/// Fingers of each hand that carry sensors.
#[must_use]
pub fn fingers(header: Option<&RunHeader>) -> [usize; 2] {
    let fingers = |wiring: &HandWiringRecord| (wiring.fingers as usize).min(FINGERS);
    header.map_or([USUAL_FINGERS; 2], |header| {
        header.hands.each_ref().map(fingers)
    })
}

/// Where each hand's elements sit; the paper's dome where nothing is recorded of it.
#[must_use]
pub fn layouts(header: Option<&RunHeader>) -> [Layout; 2] {
    let layout = |wiring: &HandWiringRecord| Layout {
        count: (wiring.element_count as usize).min(ELEMENTS),
        normal: wiring.normal,
        tangent1: wiring.tangent1,
        tangent2: wiring.tangent2,
        radius_m: wiring.radius_m,
        element_area_m2: wiring.element_area_m2,
    };
    header.map_or_else(
        || [Layout::dome_41(), Layout::dome_41()],
        |header| header.hands.each_ref().map(layout),
    )
}
