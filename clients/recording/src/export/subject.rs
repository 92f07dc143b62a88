//! Subject of messages and tables: robot, sensors, clock.

use std::array;

use anyhow::Context;
use atas_client::layouts;
use robot_model::{HandSide, JointKind, RobotFiles, Skeleton};
use shm_schemas::Layout;

use crate::clock::Clock;
use crate::origin;
use crate::rows::Rows;

/// URDF of an unknown robot.
const UNKNOWN_URDF: &str = r#"<robot name="unknown"><link name="base"/></robot>"#;

/// Robot, sensors, and the clock of the stamps.
#[derive(Debug)]
pub struct Subject {
    /// Empty for an unknown robot.
    pub(super) urdf: String,
    pub(super) skeleton: Skeleton,
    /// Kind of each joint, in the order of joint vectors.
    pub(super) kinds: Vec<JointKind>,
    /// Names of the fingertip links, per hand.
    pub(super) tips: [Vec<String>; 2],
    pub(super) layouts: [Layout; 2],
    /// Fingertips with sensors per hand; 0 for a missing hand.
    pub(super) fingers: [usize; 2],
    pub(super) clock: Clock,
    /// Version of the daemon and hash of its configuration.
    pub(super) made_by: [(&'static str, String); 2],
}

impl Subject {
    /// Creates the subject of a recording.
    ///
    /// # Errors
    /// The recorded robot cannot be loaded.
    pub(super) fn recorded(rows: &Rows) -> anyhow::Result<Self> {
        let header = rows.header();
        let text = |text: Option<String>| text.unwrap_or_else(|| "not recorded".to_owned());
        let version = text(header.map(|h| h.version.to_string()));
        let hash = text(header.map(|h| format!("{:016x}", h.config_hash)));
        let about = Self::from_robot(
            origin::robot(header, rows.robot())?,
            layouts::of_run(header),
            origin::fingers(header),
        );
        Ok(Self {
            clock: rows.clock(),
            made_by: [("atas.daemon_version", version), ("atas.config_hash", hash)],
            ..about.context("could not load the recorded robot")?
        })
    }

    /// Creates the subject of a running robot, stamped by this machine's clock. An unknown robot
    /// has no joints and no links.
    ///
    /// # Errors
    /// The robot cannot be loaded.
    pub fn live(
        robot: Option<RobotFiles>,
        layouts: [Layout; 2],
        fingers: [usize; 2],
    ) -> anyhow::Result<Self> {
        let about = match robot {
            Some(files) => Self::from_robot(files, layouts, fingers)?,
            None => Self::unknown(layouts, fingers)?,
        };
        Ok(Self {
            clock: Clock::of_this_machine(),
            ..about
        })
    }

    fn from_robot(
        files: RobotFiles,
        layouts: [Layout; 2],
        fingers: [usize; 2],
    ) -> anyhow::Result<Self> {
        let (skeleton, robot) = (files.skeleton()?, files.load()?);
        let tips = |side| robot.hand(side).tip_links().map(str::to_owned).collect();
        let is_there = HandSide::BOTH.map(|side| robot.hand(side).is_present());
        Ok(Self {
            urdf: files.urdf.into_owned(),
            skeleton,
            kinds: robot.joints().map(|joint| joint.kind).collect(),
            tips: HandSide::BOTH.map(tips),
            layouts,
            fingers: array::from_fn(|hand| if is_there[hand] { fingers[hand] } else { 0 }),
            clock: Clock::default(),
            made_by: Default::default(),
        })
    }

    fn unknown(layouts: [Layout; 2], fingers: [usize; 2]) -> anyhow::Result<Self> {
        Ok(Self {
            urdf: String::new(),
            skeleton: Skeleton::read(UNKNOWN_URDF, Vec::new())?,
            kinds: Vec::new(),
            tips: Default::default(),
            layouts,
            fingers,
            clock: Clock::default(),
            made_by: Default::default(),
        })
    }

    /// Returns names and kinds of the joints.
    pub(super) fn joints(&self) -> impl Iterator<Item = (&str, JointKind)> {
        let names = self.skeleton.joint_names().iter().map(String::as_str);
        names.zip(self.kinds.iter().copied())
    }
}
