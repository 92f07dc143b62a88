//! State, wrenches and elements of one hand.

use atas_client::{Observer, contact};
use robot_model::{GraspSide, HandPose, HandSide};
use shm_schemas::capacity::FINGERS;
use shm_schemas::{FingerReport, Hand, HandFrame, JointState, ModuleId};

use super::tactile;
use crate::clock::Clock;
use crate::middleware::{Node, Publish, Quality};
use crate::robot::KnownRobot;
use crate::wire::atas::{FingertipState, HandState};
use crate::wire::standard::{Point, PointCloud, WrenchStamped};

/// Topics of one fingertip.
struct FingertipTopics {
    wrench: Box<dyn Publish<WrenchStamped>>,
    elements: Box<dyn Publish<PointCloud>>,
}

/// Topics of one hand.
pub(super) struct HandTopics {
    side: HandSide,
    hand: Hand,
    state: Box<dyn Publish<HandState>>,
    fingertips: Vec<FingertipTopics>,
}

impl HandTopics {
    /// Opens the topics of all fingertips that a hand can have.
    pub(super) fn open(node: &mut Node, namespace: &str, index: usize) -> anyhow::Result<Self> {
        let hand = Hand::BOTH[index];
        let mut fingertips = Vec::new();
        for finger in 1..=FINGERS {
            let of = format!("{namespace}/{hand}/finger{finger}");
            fingertips.push(FingertipTopics {
                wrench: node.publisher(&format!("{of}/wrench"), Quality::STREAM)?,
                elements: node.publisher(&format!("{of}/elements"), Quality::STREAM)?,
            });
        }
        Ok(Self {
            side: HandSide::BOTH[index],
            hand,
            state: node.publisher(&format!("{namespace}/{hand}/state"), Quality::STREAM)?,
            fingertips,
        })
    }

    pub(super) fn publish(
        &mut self,
        robot: &KnownRobot,
        observer: &Observer,
        joints: &JointState,
        clock: &Clock,
        clouds: bool,
    ) -> anyhow::Result<()> {
        let index = self.side.index();
        let fingers = robot.fingers[index].min(FINGERS);
        if fingers == 0 {
            return Ok(());
        }
        let frame = &observer.view.frames[index];
        let frame = (observer.view.has_frame[index] != 0).then_some(frame);
        self.publish_state(robot, observer, joints, clock, frame)?;
        let Some(frame) = frame else { return Ok(()) };
        let layout = &robot.layouts[index];
        if frame.layout_hash != layout.hash() {
            return Ok(());
        }
        let count = fingers.min(frame.finger_count as usize);
        for (finger, topics) in self.fingertips[..count].iter().enumerate() {
            let tip = robot.tips[index]
                .get(finger)
                .map_or(robot.base(), String::as_str);
            let header = clock.header(frame.stamp.captured_ns, tip);
            let wrench = tactile::wrench(header.clone(), frame, finger, layout);
            topics.wrench.publish(wrench)?;
            if clouds {
                let cloud = tactile::cloud(header, frame, finger, layout);
                topics.elements.publish(cloud)?;
            }
        }
        Ok(())
    }

    fn publish_state(
        &self,
        robot: &KnownRobot,
        observer: &Observer,
        joints: &JointState,
        clock: &Clock,
        frame: Option<&HandFrame>,
    ) -> anyhow::Result<()> {
        let index = self.side.index();
        let (report, fingers) = (&observer.report, robot.fingers[index].min(FINGERS));
        let hand = &report.hands[index];
        let count = (joints.joint_count as usize).min(joints.position.len());
        let pose = robot.pose(self.side, &joints.position[..count]);
        let model = robot.model.hand(self.side);
        let opening_m = pose
            .as_ref()
            .map_or(f64::NAN, |pose| model.pinch_pose(pose).opening_m);
        let touching: Vec<&FingerReport> = hand.fingers[..fingers]
            .iter()
            .filter(|of| of.in_contact != 0)
            .collect();
        let sides = GraspSide::BOTH.map(|side| {
            let mut tips = model.fingertips_of(side).filter(|tip| *tip < fingers);
            tips.any(|tip| hand.fingers[tip].in_contact != 0)
        });
        let load_n = pose.as_ref().zip(frame).map_or(0.0, |(pose, frame)| {
            load_n(robot, pose, frame, index, fingers)
        });
        let friction = touching.iter().map(|of| of.friction).reduce(f32::min);
        let utilisation = touching.iter().map(|of| of.utilisation).reduce(f32::max);
        let [x, y, z] = hand.centre_m;
        self.state.publish(HandState {
            header: clock.header(report.stamp.captured_ns, robot.base()),
            hand: self.hand.to_string(),
            active_modules: modules(hand.modules_active),
            step: hand.step,
            f1_n: hand.f1_n,
            f2_n: hand.f2_n,
            stiffness_n_m: hand.stiffness_n_m,
            opening_m,
            centre_m: Point { x, y, z },
            holds_object: sides.iter().all(|touches| *touches),
            load_n,
            friction: friction.unwrap_or(0.0),
            friction_utilisation: utilisation.unwrap_or(0.0),
            fingertips: hand.fingers[..fingers].iter().map(fingertip).collect(),
        })
    }
}

/// Returns the names of the modules with a set bit.
fn modules(bits: u32) -> Vec<String> {
    let active = ModuleId::ALL
        .iter()
        .filter(|id| **id != ModuleId::NONE && bits >> id.0 & 1 == 1);
    active.map(|id| id.name().to_owned()).collect()
}

fn fingertip(of: &FingerReport) -> FingertipState {
    FingertipState {
        in_contact: of.in_contact != 0,
        normal_n: of.normal_n,
        tangential_n: of.tangential_n,
        tangential_increment_n: of.tangential_increment_n,
        utilisation: of.utilisation,
        friction: of.friction,
        closing_m_s: of.closing_m_s,
    }
}

/// Returns the downward force of the object on all fingertips, N.
fn load_n(
    robot: &KnownRobot,
    pose: &HandPose,
    frame: &HandFrame,
    index: usize,
    fingers: usize,
) -> f32 {
    let layout = &robot.layouts[index];
    let tips = pose.base_from_tip().iter().take(fingers).enumerate();
    let upward_n = tips.map(|(finger, base_from_tip)| {
        let (valid, force_n) = (frame.valid_mask[finger], &frame.force_n[finger]);
        let [force, _] = contact::wrench(layout, valid, force_n);
        let axes = [
            base_from_tip.x_axis(),
            base_from_tip.y_axis(),
            base_from_tip.z_axis(),
        ];
        axes.iter()
            .zip(force)
            .map(|(axis, part)| axis.z * part)
            .sum::<f64>()
    });
    -(upward_n.sum::<f64>()) as f32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn active_modules_are_named() {
        assert_eq!(modules(0b1_0001), ["module 2, slip"]);
        assert!(modules(0).is_empty());
    }
}
