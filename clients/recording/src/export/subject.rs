//! What messages and tables are about: the robot, its sensors, the clock.

use std::array;

use anyhow::Context;
use robot_model::{JointKind, RobotFiles, Side, Skeleton};
use shm_schemas::Layout;

use crate::clock::Clock;
use crate::origin;
use crate::rows::Rows;

/// What is known of the links of a robot that nobody knows.
const UNKNOWN: &str = r#"<robot name="unknown"><link name="base"/></robot>"#;

/// A robot, its sensors, and the clock that its stamps are of.
#[derive(Debug)]
pub struct Subject {
    /// Empty where nobody knows the robot.
    pub(super) urdf: String,
    pub(super) skeleton: Skeleton,
    /// How each joint moves, in the order of joint vectors.
    pub(super) kinds: Vec<JointKind>,
    /// Names of the links that carry the fingertips, per hand.
    pub(super) tips: [Vec<String>; 2],
    pub(super) layouts: [Layout; 2],
    /// Fingers of each hand that feel; none of a hand that the robot has not.
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

    /// Of a robot that moves now, stamped by this machine's clock. Of one that nobody knows there are no joints and no links.
    ///
    /// # Errors
    /// The robot cannot be loaded.
    pub fn live(
        robot: Option<RobotFiles>,
        layouts: [Layout; 2],
        fingers: [usize; 2],
    ) -> anyhow::Result<Self> {
        let about = match robot {
            Some(files) => Self::about(files, layouts, fingers)?,
            None => Self::unknown(layouts, fingers)?,
        };
        Ok(Self {
            clock: Clock::of_this_machine(),
            ..about
        })
    }

    fn about(files: RobotFiles, layouts: [Layout; 2], fingers: [usize; 2]) -> anyhow::Result<Self> {
        let (skeleton, robot) = (files.skeleton()?, files.load()?);
        let tips = |side| robot.hand(side).tip_links().map(str::to_owned).collect();
        let is_there = Side::BOTH.map(|side| robot.hand(side).is_present());
        Ok(Self {
            urdf: files.urdf.into_owned(),
            skeleton,
            kinds: robot.joints().map(|joint| joint.kind).collect(),
            tips: Side::BOTH.map(tips),
            layouts,
            fingers: array::from_fn(|hand| if is_there[hand] { fingers[hand] } else { 0 }),
            clock: Clock::default(),
            made_by: Default::default(),
        })
    }

    fn unknown(layouts: [Layout; 2], fingers: [usize; 2]) -> anyhow::Result<Self> {
        Ok(Self {
            urdf: String::new(),
            skeleton: Skeleton::read(UNKNOWN, Vec::new())?,
            kinds: Vec::new(),
            tips: Default::default(),
            layouts,
            fingers,
            clock: Clock::default(),
            made_by: Default::default(),
        })
    }

    /// The names of the joints with how each moves.
    pub(super) fn joints(&self) -> impl Iterator<Item = (&str, JointKind)> {
        let names = self.skeleton.joint_names().iter().map(String::as_str);
        names.zip(self.kinds.iter().copied())
    }
}
