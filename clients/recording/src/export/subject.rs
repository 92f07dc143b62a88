//! What messages and tables are about: the robot, its sensors, the clock.

use anyhow::Context;
use robot_model::{Side, Skeleton};
use shm_schemas::Layout;

use crate::clock::Clock;
use crate::origin;
use crate::rows::Rows;

/// A robot, its sensors, and the clock that its stamps are of.
#[derive(Debug)]
pub(super) struct Subject {
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
        let files = origin::robot(header)?;
        let skeleton = files
            .skeleton()
            .context("could not load the recorded robot")?;
        let robot = files.load().context("could not load the recorded robot")?;
        let tips = |side| robot.hand(side).tip_links().map(str::to_owned).collect();
        Ok(Self {
            urdf: files.urdf.into_owned(),
            skeleton,
            tips: Side::BOTH.map(tips),
            layouts: origin::layouts(header),
            fingers: origin::fingers(header),
            clock: rows.clock(),
            made_by: [("atas.daemon_version", version), ("atas.config_hash", hash)],
        })
    }
}
