//! Measurements that goals need: status, joints, robot.

use std::collections::BTreeMap;
use std::time::{Duration, Instant};

use atas_client::Session;
use robot_model::{HandSide, PinchPose};
use shm_bus::{BusError, Subscriber};
use shm_schemas::{Mode, Status, View, service};

use crate::robot::{KnownRobot, RobotWatch};

/// Silence after which a daemon counts as gone. Design choice: 50 missing statuses.
const SILENCE: Duration = Duration::from_secs(1);

/// Newest measurements of one daemon.
pub(super) struct Scene {
    statuses: Subscriber<Status>,
    views: Subscriber<View>,
    view: Box<View>,
    robot: RobotWatch,
    heard: Instant,
    /// Newest status; process id 0 before the first.
    pub(super) status: Status,
}

impl Scene {
    pub(super) fn join(session: &Session) -> Result<Self, BusError> {
        let bus = session.bus();
        Ok(Self {
            statuses: bus.subscriber(service::STATUS)?,
            views: bus.subscriber(service::VIEW)?,
            view: Box::default(),
            robot: RobotWatch::default(),
            heard: Instant::now(),
            status: Status::default(),
        })
    }

    pub(super) fn poll(&mut self, session: &Session) -> Result<(), BusError> {
        if self.statuses.newest(&mut self.status)? {
            self.heard = Instant::now();
        }
        self.views.newest(&mut self.view)?;
        self.robot.poll(session.bus(), &self.status)?;
        Ok(())
    }

    /// Returns true if the daemon reports.
    pub(super) fn is_fresh(&self) -> bool {
        self.heard.elapsed() < SILENCE
    }

    /// Returns true if the daemon starts or re-arms, so that it would reject a goal.
    pub(super) fn is_arming(&self) -> bool {
        self.status.pid == 0 || matches!(self.status.mode, Mode::INIT | Mode::HOLD)
    }

    /// Returns the robot, if known.
    pub(super) fn robot(&self) -> Option<&KnownRobot> {
        self.robot.robot()
    }

    /// Returns the measured pose of a hand.
    pub(super) fn measured(&self, side: HandSide) -> Option<PinchPose> {
        let joints = &self.view.joints;
        let count = (joints.joint_count as usize).min(joints.position.len());
        self.robot()?.pinch(side, &joints.position[..count])
    }

    /// Returns the commanded pose of a hand; the measured one if the robot does not report it.
    pub(super) fn commanded(&self, side: HandSide) -> Option<PinchPose> {
        let joints = &self.view.joints;
        let count = (joints.commanded_count as usize).min(joints.commanded_position.len());
        let commanded = self
            .robot()?
            .pinch(side, &joints.commanded_position[..count]);
        commanded.or_else(|| self.measured(side))
    }

    /// Returns the pose of a hand with some joints at other positions.
    pub(super) fn with_joints(
        &self,
        side: HandSide,
        wanted: &BTreeMap<String, f64>,
    ) -> Option<PinchPose> {
        let joints = &self.view.joints;
        let count = (joints.joint_count as usize).min(joints.position.len());
        let names = self.robot()?.skeleton.joint_names().iter();
        let measured = joints.position[..count].iter();
        let q = measured
            .zip(names)
            .map(|(q, name)| *wanted.get(name).unwrap_or(q));
        self.robot()?.pinch(side, &q.collect::<Vec<f64>>())
    }
}
