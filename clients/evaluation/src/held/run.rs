//! One run of a trial: controller and world in turn, with loads from outside.

use anyhow::Context;
use atas_client::goal::LIFT_M;
use atas_core::OperatorRequest;
use robot_model::{GRASP_SIDES, HandVector, RobotModel};
use shm_schemas::{EventKind, JointCommand, Mode, ObjectTruth};
use sim_backend::{TICK_NS, World};

use super::position::PositionGripper;
use super::{Grip, HeldTrial, LIFTED_SHARE, discarded};
use crate::offline::OfflineRun;

/// Run in progress.
pub(crate) struct HeldRun<'a> {
    robot: &'a RobotModel,
    run: OfflineRun,
    request: Option<OperatorRequest>,
    gripper: Option<PositionGripper>,
    seed: u64,
    /// True after the controller became ready; before, HOLD is normal.
    is_ready: bool,
    warned: bool,
    command: JointCommand,
}

impl<'a> HeldRun<'a> {
    pub(super) fn new(trial: &HeldTrial<'a>, grip: Grip) -> anyhow::Result<Self> {
        let settings = grip.settings(&trial.settings);
        let mut run = OfflineRun::in_world(trial.robot, &trial.scene, trial.world()?, settings);
        if !trial.has_torques {
            run.hide_torques();
        }
        run.make_ready(&mut |_| {});
        let (goal, gripper) = match grip {
            Grip::Policy(policy) => {
                let (goal, task) = policy.goal(&trial.goal);
                run.set_task(task);
                (goal, None)
            }
            Grip::Position(margin_m) => {
                let side = trial.robot.acting_side();
                let gripper = PositionGripper::new(trial.hint, side, margin_m, run.world());
                (gripper.goal(), Some(gripper))
            }
        };
        Ok(Self {
            robot: trial.robot,
            // A drifting sensor may keep the controller from becoming ready: then nothing is
            // lifted.
            request: run.request(&goal).ok(),
            gripper,
            seed: trial.seed,
            is_ready: run.controller().mode().0 == Mode::READY,
            warned: false,
            command: JointCommand::default(),
            run,
        })
    }

    /// Runs one tick.
    pub(crate) fn step(&mut self) {
        let target = self.gripper.as_mut();
        let now_ns = self.run.world().now_ns();
        let target = target.and_then(|gripper| gripper.target(now_ns));
        if let Some(target) = target {
            self.run.push_target(target);
        }
        let outputs = self.run.step(self.request.take().as_ref());
        let mut events = outputs.events.as_slice().iter();
        let warned = events.any(|event| event.kind == EventKind::WARNING);
        self.command = outputs.command;
        let holds = self.is_ready && self.run.controller().mode().0 == Mode::HOLD;
        self.warned |= warned || holds;
    }

    /// Runs until the object is lifted by half; returns the time from the start of the simulation,
    /// s, or `None` after `limit_s`.
    pub(crate) fn lift(&mut self, limit_s: f64) -> Option<f64> {
        while self.now_s() < limit_s && self.world().fault().is_none() {
            self.step();
            if self.object().lifted_m >= LIFTED_SHARE * LIFT_M {
                return Some(self.now_s());
            }
        }
        None
    }

    /// Runs for this time; calls `each` before every tick with the time since the call, s.
    ///
    /// # Errors
    /// Those of `each`.
    pub(crate) fn hold(
        &mut self,
        time_s: f64,
        mut each: impl FnMut(&mut Self, f64) -> anyhow::Result<()>,
    ) -> anyhow::Result<()> {
        let begin_s = self.now_s();
        while self.now_s() < begin_s + time_s && self.world().fault().is_none() {
            let since_s = self.now_s() - begin_s;
            each(self, since_s)?;
            self.step();
        }
        Ok(())
    }

    /// Returns the reason if the engine discarded the trial.
    ///
    /// # Errors
    /// Any other fault of the world.
    pub(crate) fn discarded(&self) -> anyhow::Result<Option<String>> {
        discarded(self.world()).with_context(|| format!("seed {}", self.seed))
    }

    pub(crate) fn now_s(&self) -> f64 {
        self.world().tick() as f64 * TICK_NS as f64 * 1e-9
    }

    pub(crate) fn world(&self) -> &World {
        self.run.world()
    }

    pub(crate) fn world_mut(&mut self) -> &mut World {
        self.run.world_mut()
    }

    pub(crate) fn object(&self) -> ObjectTruth {
        self.world().truth().objects[0]
    }

    /// Returns true if the controller reported a warning or was in HOLD.
    pub(crate) fn warned(&self) -> bool {
        self.warned
    }

    /// Returns the index of the acting hand.
    pub(crate) fn hand(&self) -> usize {
        self.robot.acting_side().index()
    }

    /// Returns the mean normal force per grasp side, N.
    pub(crate) fn grip_n(&self) -> f64 {
        let normal_n = self.world().truth().normal_n[self.hand()];
        normal_n.iter().sum::<f64>() / GRASP_SIDES as f64
    }

    /// Returns the largest sliding distance of the hand's fingertips since their touch, m.
    pub(crate) fn slid_m(&self) -> f64 {
        let slip_m = self.world().truth().slip_m[self.hand()];
        slip_m.into_iter().fold(0.0, f64::max)
    }

    /// Returns the commanded distance between the grasp sides, m.
    pub(crate) fn commanded_opening_m(&self) -> f64 {
        let side = self.robot.acting_side();
        let commanded = &self.command.position[self.robot.joint_range(side)];
        let pose = self
            .robot
            .hand(side)
            .forward(&HandVector::from_slice(commanded));
        pose.across_m().norm()
    }
}
