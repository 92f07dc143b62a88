//! Joint states, transforms and robot description.

use shm_schemas::JointState as BusJoints;

use crate::clock::Clock;
use crate::middleware::{Node, Publish, Quality};
use crate::robot::KnownRobot;
use crate::wire::standard::{
    JointState, Quaternion, Text, Transform, TransformStamped, Transforms, Vector3,
};

/// Topics of the whole robot; none if another node publishes the robot.
pub(super) struct JointTopics(Option<RobotTopics>);

struct RobotTopics {
    joints: Box<dyn Publish<JointState>>,
    transforms: Box<dyn Publish<Transforms>>,
    description: Box<dyn Publish<Text>>,
}

impl JointTopics {
    pub(super) fn open(node: &mut Node, publishes_robot: bool) -> anyhow::Result<Self> {
        if !publishes_robot {
            return Ok(Self(None));
        }
        Ok(Self(Some(RobotTopics {
            joints: node.publisher("/joint_states", Quality::STREAM)?,
            transforms: node.publisher("/tf", Quality::STREAM)?,
            description: node.publisher("/robot_description", Quality::LATCHED)?,
        })))
    }

    pub(super) fn describe(&self, robot: &KnownRobot) -> anyhow::Result<()> {
        let Some(topics) = &self.0 else { return Ok(()) };
        topics.description.publish(Text {
            data: robot.urdf.clone(),
        })
    }

    pub(super) fn publish(
        &self,
        robot: &KnownRobot,
        joints: &BusJoints,
        clock: &Clock,
    ) -> anyhow::Result<()> {
        let Some(topics) = &self.0 else { return Ok(()) };
        let names = robot.skeleton.joint_names();
        let count = (joints.joint_count as usize)
            .min(names.len())
            .min(joints.position.len());
        topics.joints.publish(JointState {
            header: clock.header(joints.stamp.captured_ns, ""),
            name: names[..count].to_vec(),
            position: joints.position[..count].to_vec(),
            velocity: joints.velocity[..count].to_vec(),
            effort: joints.effort[..count].to_vec(),
        })
    }

    pub(super) fn transforms(
        &self,
        robot: &KnownRobot,
        joints: &BusJoints,
        clock: &Clock,
    ) -> anyhow::Result<()> {
        let count = (joints.joint_count as usize).min(joints.position.len());
        let Some(topics) = self.0.as_ref().filter(|_| count > 0) else {
            return Ok(());
        };
        let limbs = robot.skeleton.limbs();
        let placed = limbs.iter().filter_map(|limb| {
            let parent = limbs[limb.parent?].name.as_str();
            let at = limb.placed(&joints.position[..count]);
            let [x, y, z] = at.translation_m;
            let [qx, qy, qz, qw] = at.rotation_xyzw;
            Some(TransformStamped {
                header: clock.header(joints.stamp.captured_ns, parent),
                child_frame_id: limb.name.clone(),
                transform: Transform {
                    translation: Vector3 { x, y, z },
                    rotation: Quaternion {
                        x: qx,
                        y: qy,
                        z: qz,
                        w: qw,
                    },
                },
            })
        });
        topics.transforms.publish(Transforms {
            transforms: placed.collect(),
        })
    }
}
