//! What messages and tables are about: the robot, its sensors, the clock.

use anyhow::Context;
use robot_model::{RobotFiles, Side, Skeleton};
use shm_schemas::Layout;

use crate::clock::Clock;
use crate::origin;
use crate::rows::Rows;

/// A robot, its sensors, and the clock that its stamps are of.
#[derive(Debug)]
pub struct Subject {
    pub(super) urdf: String,
    pub(super) skeleton: Skeleton,
    /// Names of the links that carry the fingertips, per hand.
    pub(super) tips: [Vec<String>; 2],
    pub(super) layouts: [Layout; 2],
    pub(super) fingers: [usize; 2],
    pub(super) clock: Clock,
    /// Version of the daemon and hash of its configuration.
    pub(super) made_by: [(&'static str, String); 2],
}

impl Subject {
    /// Of a recording.
    ///
    /// # Errors
    /// The recorded robot cannot be loaded.
    pub(super) fn recorded(rows: &Rows) -> anyhow::Result<Self> {
        let header = rows.header();
        let text = |text: Option<String>| text.unwrap_or_else(|| "not recorded".to_owned());
        let version = text(header.map(|h| h.version.to_string()));
        let hash = text(header.map(|h| format!("{:016x}", h.config_hash)));
        let about = Self::about(
            origin::robot(header, rows.robot())?,
            origin::layouts(header),
            origin::fingers(header),
        );
        Ok(Self {
            clock: rows.clock(),
            made_by: [("atas.daemon_version", version), ("atas.config_hash", hash)],
            ..about.context("could not load the recorded robot")?
        })
    }

    /// Of a robot that moves now, stamped by this machine's clock.
    ///
    /// # Errors
    /// The robot cannot be loaded.
    pub fn live(
        files: RobotFiles,
        layouts: [Layout; 2],
        fingers: [usize; 2],
    ) -> anyhow::Result<Self> {
        Ok(Self {
            clock: Clock::of_this_machine(),
            ..Self::about(files, layouts, fingers)?
        })
    }

    fn about(files: RobotFiles, layouts: [Layout; 2], fingers: [usize; 2]) -> anyhow::Result<Self> {
        let (skeleton, robot) = (files.skeleton()?, files.load()?);
        let tips = |side| robot.hand(side).tip_links().map(str::to_owned).collect();
        Ok(Self {
            urdf: files.urdf.into_owned(),
            skeleton,
            tips: Side::BOTH.map(tips),
            layouts,
            fingers,
            clock: Clock::default(),
            made_by: Default::default(),
        })
    }
}
