//! Features of a frame: names and values of state, action and environment.
//!
//! The names equal those of the LeRobot robot `atas` (package `lerobot_robot_atas`), so that a
//! policy trained on an exported data set runs on that robot.

use anyhow::Context;
use robot_model::{HandSide, HandVector, PinchPose, RobotModel};
use shm_schemas::{GoalRequest, GraspTarget, GripOrder, HandReport, JointState, ModuleId};

use crate::rows::{Row, RowInputs};

/// Components of an element's force: normal, and along both tangents.
const COMPONENTS: [&str; 3] = ["fn", "ft1", "ft2"];
/// Names of a pinch pose: point between the fingertips (m), closing axis (rad), opening (m).
pub(super) const POSE: [&str; 5] = ["hand.x", "hand.y", "hand.z", "hand.yaw", "hand.opening"];
/// Names of a goal's data: expected object, and the place of a pick and place. Zero if unknown.
pub(super) const ENVIRONMENT: [&str; 8] = [
    "object.x",
    "object.y",
    "object.z",
    "object.yaw",
    "object.width",
    "place.x",
    "place.y",
    "place.z",
];

/// Features of one hand.
pub(super) struct Features {
    robot: RobotModel,
    pub(super) side: HandSide,
    fingers: usize,
    /// Elements per fingertip; 0 leaves them out.
    elements: usize,
    joints: Vec<String>,
}

/// Newest values of a run, which later ticks without new values repeat.
#[derive(Default)]
pub(super) struct Newest {
    joints: Option<JointState>,
    hand: Option<HandReport>,
    /// Forces of the elements, N.
    taxels: Vec<f32>,
    commanded: Option<Vec<f64>>,
    target: Option<GraspTarget>,
}

impl Features {
    pub(super) fn new(robot: RobotModel, side: HandSide, fingers: usize, elements: usize) -> Self {
        let joints = robot.hand(side).joints().iter();
        let joints = joints.map(|joint| joint.name.to_string()).collect();
        Self {
            robot,
            side,
            fingers,
            elements,
            joints,
        }
    }

    /// Names of `observation.state`, in order.
    pub(super) fn state_names(&self) -> Vec<String> {
        let mut names: Vec<String> = POSE.map(str::to_owned).into();
        names.extend(self.joints.iter().map(|joint| format!("{joint}.pos")));
        for finger in 1..=self.fingers {
            names.extend(
                ["normal_n", "tangential_n", "utilisation", "in_contact"]
                    .map(|what| format!("finger{finger}.{what}")),
            );
        }
        names.extend(["grip.f1_n", "grip.f2_n"].map(str::to_owned));
        names.extend(modules().map(|id| format!("module.{}", super::super::messages::word(id))));
        names
    }

    /// Names of `observation.taxels`, in order; empty without elements.
    pub(super) fn taxel_names(&self) -> Vec<String> {
        let mut names = Vec::new();
        for finger in 1..=self.fingers {
            for element in 0..self.elements {
                names.extend(
                    COMPONENTS.map(|axis| format!("finger{finger}.element{element}.{axis}_n")),
                );
            }
        }
        names
    }

    /// Values of `observation.state`; `None` before the first joint state and report.
    pub(super) fn state(&self, newest: &Newest) -> Option<Vec<f32>> {
        let (joints, hand) = (newest.joints.as_ref()?, newest.hand.as_ref()?);
        let range = self.robot.joint_range(self.side);
        let own = joints.position.get(range)?;
        let mut values: Vec<f32> = numbers(&self.pinch_pose(own)).into();
        values.extend(own.iter().map(|position| *position as f32));
        for finger in &hand.fingers[..self.fingers] {
            values.extend([
                finger.normal_n,
                finger.tangential_n,
                finger.utilisation,
                finger.in_contact as f32,
            ]);
        }
        values.extend([hand.f1_n, hand.f2_n]);
        values.extend(modules().map(|id| (hand.modules_active >> id.0 & 1) as f32));
        Some(values)
    }

    /// Values of `observation.taxels`: zero for elements without a valid value so far.
    pub(super) fn taxels(&self, newest: &Newest) -> Vec<f32> {
        let mut values = newest.taxels.clone();
        values.resize(self.taxel_names().len(), 0.0);
        values
    }

    /// Values of `action`: the newest target of a teleoperated hand, else the commanded pinch pose;
    /// `None` before the first command.
    pub(super) fn action(&self, newest: &Newest) -> Option<[f32; 5]> {
        let commanded = newest.commanded.as_ref()?;
        let pose = self.pinch_pose(commanded);
        Some(match &newest.target {
            None => numbers(&pose),
            Some(target) => {
                let opening_m = match target.grip {
                    GripOrder::WIDTH => target.opening_m,
                    _ => pose.opening_m,
                };
                let [x, y, z] = target.centre_m;
                [x, y, z, target.closing_yaw_rad, opening_m].map(|value| value as f32)
            }
        })
    }

    /// Values of `observation.environment_state`.
    pub(super) fn environment(goal: &GoalRequest) -> [f32; 8] {
        if goal.kind.is_stream() {
            return [0.0; 8];
        }
        let ([x, y, z], [to_x, to_y, to_z]) = (goal.from_m, goal.to_m);
        let values = [x, y, z, goal.from_yaw_rad, goal.width_m, to_x, to_y, to_z];
        values.map(|value| value as f32)
    }

    fn pinch_pose(&self, position: &[f64]) -> PinchPose {
        let hand = self.robot.hand(self.side);
        hand.pinch_pose(&hand.forward(&HandVector::from_slice(position)))
    }

    /// Takes the values of a tick.
    ///
    /// # Errors
    /// A value is not finite: statistics and policies need numbers.
    pub(super) fn update(&self, newest: &mut Newest, row: &Row) -> anyhow::Result<()> {
        let hand = self.side.index();
        if let Some(report) = &row.report {
            newest.hand = Some(report.hands[hand]);
        }
        let Some(inputs) = row.inputs.as_deref() else {
            return Ok(());
        };
        newest.joints = inputs.joints.or(newest.joints);
        let range = self.robot.joint_range(self.side);
        if inputs.command.joint_count as usize >= range.end {
            newest.commanded = inputs.command.position.get(range).map(<[f64]>::to_vec);
        }
        if let Some(target) = inputs.target[hand] {
            newest.target = Some(target);
        }
        self.update_taxels(newest, inputs, hand);
        let state = self.state(newest).into_iter().flatten();
        let action = self.action(newest).into_iter().flatten();
        let mut values = state.chain(action).chain(newest.taxels.iter().copied());
        values.all(f32::is_finite).then_some(()).with_context(|| {
            format!(
                "tick {} has a value that is not finite; a data set needs numbers; check the \
                     recording with `atas export --to csv`",
                row.tick
            )
        })
    }

    fn update_taxels(&self, newest: &mut Newest, inputs: &RowInputs, hand: usize) {
        let Some(frame) = &inputs.frames[hand] else {
            return;
        };
        newest
            .taxels
            .resize(self.fingers * self.elements * COMPONENTS.len(), 0.0);
        let mut values = newest.taxels.iter_mut();
        for finger in 0..self.fingers {
            for element in 0..self.elements {
                let is_valid = frame.valid_mask[finger] >> element & 1 == 1;
                for axis in 0..COMPONENTS.len() {
                    if let (Some(value), true) = (values.next(), is_valid) {
                        *value = frame.force_n[finger][element][axis];
                    }
                }
            }
        }
    }
}

impl Newest {
    /// Forgets the target of the previous goal.
    pub(super) fn begin_goal(&mut self) {
        self.target = None;
    }
}

fn modules() -> impl Iterator<Item = ModuleId> {
    ModuleId::ALL
        .iter()
        .copied()
        .filter(|id| *id != ModuleId::NONE)
}

fn numbers(pose: &PinchPose) -> [f32; 5] {
    let [x, y, z]: [f64; 3] = pose.centre_m.into();
    [x, y, z, pose.closing_yaw_rad, pose.opening_m].map(|value| value as f32)
}
