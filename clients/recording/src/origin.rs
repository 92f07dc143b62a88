//! What a recording's header says of the robot and its sensors, ready to compute with.

use std::borrow::Cow;

use anyhow::Context;
use robot_model::TWO_HAND_ARM;
use shm_schemas::capacity::{ELEMENTS, FINGERS};
use shm_schemas::layout::{FNV_OFFSET, fnv1a};
use shm_schemas::{HandWiringRecord, Layout, RunHeader};

/// How the daemon names the robot that is built in.
const BUILT_IN: &str = "built-in";
/// Fingers of a hand of which nothing is recorded: the built-in robot's.
const USUAL_FINGERS: usize = 2;

/// The URDF of the recorded robot; the built-in one where nothing is recorded of it.
///
/// # Errors
/// Its file cannot be read, or has changed since.
pub fn urdf(header: Option<&RunHeader>) -> anyhow::Result<Cow<'static, str>> {
    let Some(header) = header.filter(|header| header.robot.as_str() != BUILT_IN) else {
        return Ok(Cow::Borrowed(TWO_HAND_ARM.urdf));
    };
    let name = header.robot.as_str();
    let text = std::fs::read_to_string(name).with_context(|| {
        format!("could not read the recorded robot {name}; put its URDF back there")
    })?;
    anyhow::ensure!(
        fnv1a(FNV_OFFSET, text.as_bytes()) == header.robot_hash,
        "could not use the robot {name} because it changed since the recording; put the recorded URDF back there"
    );
    Ok(Cow::Owned(text))
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
