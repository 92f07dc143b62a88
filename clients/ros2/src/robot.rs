//! Robot of the running daemon: kinematics, element layouts, names.

use atas_client::{Run, layouts};
use robot_model::{HandPose, HandSide, HandVector, PinchPose, RobotFiles, RobotModel, Skeleton};
use shm_bus::{Bus, BusError};
use shm_schemas::capacity::HANDS;
use shm_schemas::{Layout, RunHeader, Status};

/// Frame of the robot's base if the URDF names none.
const BASE: &str = "base";

/// Robot and sensors of a run.
pub(crate) struct KnownRobot {
    /// Description of links and joints for viewers.
    pub(crate) urdf: String,
    /// Links and joints.
    pub(crate) skeleton: Skeleton,
    /// Kinematics of the hands.
    pub(crate) model: RobotModel,
    /// Element layout of each hand.
    pub(crate) layouts: [Layout; HANDS],
    /// Fingertips with sensors per hand; 0 for a missing hand.
    pub(crate) fingers: [usize; HANDS],
    /// Links of the fingertips, per hand.
    pub(crate) tips: [Vec<String>; HANDS],
}

/// Robot of the daemon, kept up to date.
#[derive(Default)]
pub(crate) struct RobotWatch {
    run: Run,
    robot: Option<KnownRobot>,
    /// Process id, hash of the robot and fingertips of `robot`.
    key: (u32, u64, [usize; HANDS]),
}

impl RobotWatch {
    /// Checks for another run; returns true if the robot changed.
    ///
    /// # Errors
    /// The shared memory of the daemon cannot be read.
    pub(crate) fn poll(&mut self, bus: &Bus, status: &Status) -> Result<bool, BusError> {
        self.run.poll(bus, status)?;
        let Some(header) = self.run.header() else {
            return Ok(false);
        };
        let key = (status.pid, header.robot_hash, self.run.fingertips(status));
        if key == self.key {
            return Ok(false);
        }
        self.key = key;
        match KnownRobot::from_header(header, key.2) {
            Ok(robot) => self.robot = Some(robot),
            Err(why) => {
                tracing::warn!("{why}; joints, transforms and tactile data are not published");
                self.robot = None;
            }
        }
        Ok(true)
    }

    /// Returns the robot, if known.
    #[must_use]
    pub(crate) fn robot(&self) -> Option<&KnownRobot> {
        self.robot.as_ref()
    }
}

impl KnownRobot {
    fn from_header(header: &RunHeader, fingers: [usize; HANDS]) -> Result<Self, String> {
        let name = header.robot.as_str();
        let failure = |why: String| format!("could not load robot {name} of the daemon: {why}");
        let files = RobotFiles::find(name).map_err(|error| failure(error.to_string()))?;
        if files.hash() != header.robot_hash {
            return Err(failure(
                "its files differ from those that the daemon has loaded; restart the daemon"
                    .to_owned(),
            ));
        }
        let skeleton = files.skeleton().map_err(|e| failure(e.to_string()))?;
        let model = files.load().map_err(|e| failure(e.to_string()))?;
        let tips = |side| model.hand(side).tip_links().map(str::to_owned).collect();
        Ok(Self {
            tips: HandSide::BOTH.map(tips),
            fingers: HandSide::BOTH.map(|side| {
                let is_there = model.hand(side).is_present();
                if is_there { fingers[side.index()] } else { 0 }
            }),
            layouts: layouts::of_run(Some(header)),
            urdf: files.urdf.into_owned(),
            skeleton,
            model,
        })
    }

    /// Returns the frame of the base: the link without parent.
    #[must_use]
    pub(crate) fn base(&self) -> &str {
        let limbs = self.skeleton.limbs().iter();
        let root = limbs.clone().find(|limb| limb.parent.is_none());
        root.map_or(BASE, |limb| limb.name.as_str())
    }

    /// Returns the posture of a hand; `None` for a missing hand or too few joints.
    #[must_use]
    pub(crate) fn pose(&self, side: HandSide, q: &[f64]) -> Option<HandPose> {
        let hand = self.model.hand(side);
        let range = self.model.joint_range(side);
        let q = q.get(range).filter(|_| hand.is_present())?;
        let is_finite = q.iter().all(|q| q.is_finite());
        is_finite.then(|| hand.forward(&HandVector::from_slice(q)))
    }

    /// Returns point, direction and opening of a hand.
    #[must_use]
    pub(crate) fn pinch(&self, side: HandSide, q: &[f64]) -> Option<PinchPose> {
        let pose = self.pose(side, q)?;
        Some(self.model.hand(side).pinch_pose(&pose))
    }
}
