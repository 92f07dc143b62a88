//! Scripted robot, in place of a controller.
#![allow(dead_code, reason = "every test binary uses only a part")]

use nalgebra::Vector3;
use robot_model::{GraspPose, HandSide, HandVector, IkWeights, RobotModel, RobotVector};
use shm_schemas::JointCommand;
use sim_backend::{GraspHint, Scene, Sensed, World};

/// Scripted hand: converts a grasp pose to commands for the whole robot.
pub(crate) struct Script {
    pub(crate) robot: RobotModel,
    pub(crate) world: World,
    pub(crate) sensed: Sensed,
    pub(crate) frame: GraspPose,
    side: HandSide,
    q: HandVector,
    others_rad: RobotVector,
    sequence: u64,
}

/// Start distance of the fingertips from the object on both sides, m.
pub(crate) const START_GAP_M: f64 = 0.002;

impl Script {
    /// Places the hand around the nominal grasp, [`START_GAP_M`] away on both sides.
    pub(crate) fn from_nominal_grasp(scene: Scene, side: HandSide, seed: u64) -> Self {
        let robot = RobotModel::two_hand_arm().expect("the built-in robot loads");
        let hand = robot.hand(side);
        let GraspHint {
            from_m,
            yaw_rad,
            width_m,
            ..
        } = scene.grasp_hint(0).expect("scene has an object");
        let centre_m = Vector3::from(from_m);
        let yaw_rad = hand.closing_yaw_rad(&centre_m, yaw_rad);
        let frame = GraspPose::from_above(centre_m, yaw_rad, width_m + 2.0 * START_GAP_M);
        Self::from_pose(scene, side, frame, seed)
    }

    /// Places the hand at a grasp pose, the other hand at the scene's start posture or at home.
    pub(crate) fn from_pose(mut scene: Scene, side: HandSide, frame: GraspPose, seed: u64) -> Self {
        let robot = RobotModel::two_hand_arm().expect("the built-in robot loads");
        let q = robot
            .hand(side)
            .posture_for(&frame)
            .expect("reachable grasp pose")
            .q;
        let home = || sim_backend::home(&robot).expect("home posture exists");
        let mut start = scene.start.unwrap_or_else(home);
        start[robot.joint_range(side)].copy_from_slice(&q);
        scene.start = Some(start);
        let world = World::new(&robot, &scene, seed).expect("valid scene");
        Self {
            robot,
            world,
            sensed: Sensed::default(),
            frame,
            side,
            q,
            others_rad: start,
            sequence: 0,
        }
    }

    pub(crate) fn start(&self) -> RobotVector {
        self.others_rad
    }

    /// Continues with the other hand, at `frame`; this hand keeps its commanded position.
    pub(crate) fn change_hand(&mut self, frame: GraspPose) {
        self.others_rad[self.robot.joint_range(self.side)].copy_from_slice(&self.q);
        self.side = match self.side {
            HandSide::Left => HandSide::Right,
            HandSide::Right => HandSide::Left,
        };
        self.q = HandVector::from_slice(&self.others_rad[self.robot.joint_range(self.side)]);
        self.frame = frame;
    }

    /// Simulates one tick: sense, one step of inverse kinematics, advance.
    pub(crate) fn tick(&mut self) {
        self.world.sense(&mut self.sensed);
        let command = self.command();
        self.world.advance(Some(&command));
    }

    pub(crate) fn ticks(&mut self, count: usize, mut change: impl FnMut(&mut Self)) {
        for _ in 0..count {
            change(self);
            self.tick();
        }
    }

    pub(crate) fn command(&mut self) -> JointCommand {
        let hand = self.robot.hand(self.side);
        let pose = hand.forward(&self.q);
        let target = self.frame.target(hand);
        let step = hand.ik_step(
            &pose,
            &hand.jacobian(&pose),
            &target,
            1e-3,
            &IkWeights::TICK,
        );
        self.q = step.q;
        let mut command = JointCommand::default();
        let joints = self.others_rad.len();
        command.position[..joints].copy_from_slice(&self.others_rad);
        let range = self.robot.joint_range(self.side);
        command.position[range.clone()].copy_from_slice(&step.q);
        let speeds_rad_s = step.dq.map(|dq| dq / 1e-3);
        command.velocity[range].copy_from_slice(&speeds_rad_s);
        command.stamp.sequence = self.sequence;
        command.answers_sequence = self.sensed.joints.stamp.sequence;
        command.joint_count = joints as u32;
        command.valid_until_ns = self.world.now_ns() + 5_000_000;
        command.seal();
        self.sequence += 1;
        command
    }

    /// Closes both fingers at 2 mm/s each until both true normal forces reach `force_n`.
    pub(crate) fn close_to(&mut self, force_n: f64) {
        for _ in 0..20_000 {
            if self.normal_n() >= force_n {
                break;
            }
            self.frame
                .half_opening_m
                .iter_mut()
                .for_each(|half| *half -= 2e-6);
            self.tick();
        }
        self.ticks(100, |_| ());
    }

    /// Returns the smaller true normal force of the two fingertips, N.
    pub(crate) fn normal_n(&self) -> f64 {
        let [a, b, ..] = self.world.truth().normal_n[self.side.index()];
        a.min(b)
    }

    /// Moves up by `height_m` at 10 mm/s.
    pub(crate) fn lift(&mut self, height_m: f64) {
        self.ticks((height_m / 1e-5) as usize, |script| {
            script.frame.centre_m.z += 1e-5
        });
    }
}
