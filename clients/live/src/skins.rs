//! Where the elements of each hand's fingertips sit: what the robot file says, or another layout that frames name.

use atas_client::layouts;
use robot_model::{ModelError, RobotFiles, Side};
use shm_schemas::Layout;
use shm_schemas::capacity::HANDS;

/// The robot's layouts.
#[derive(Clone)]
pub(crate) struct Skins(pub(crate) [Layout; HANDS]);

impl Skins {
    pub(crate) fn of(files: &RobotFiles) -> Result<Self, ModelError> {
        let robot = files.load()?;
        Ok(Self(
            Side::BOTH.map(|side| robot.hand(side).skin().layout.layout()),
        ))
    }

    /// The layout of this hash that a hand's frames carry, if anybody knows it.
    pub(crate) fn named(&self, hand: usize, hash: u64) -> Option<Layout> {
        let robots = &self.0[hand];
        if robots.hash() == hash {
            Some(*robots)
        } else {
            layouts::named(hash)
        }
    }
}
