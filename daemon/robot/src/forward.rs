//! Forward kinematics of one hand: joint angles in, the frames of all joints, of the hand and of both tips out.

use nalgebra::Vector3;

use crate::capsule::Capsules;
use crate::model::{HandModel, PARENT, finger_root};
use crate::sizes::{ARM_JOINTS, FINGER_JOINTS, FINGERS, HAND_JOINTS, HandVector};
use crate::transform::Transform;

/// Where everything of one hand is for one joint vector; all coordinates in the base frame.
///
/// Made only by [`HandModel::forward`], so frames and joint angles always belong together.
#[derive(Clone, Debug, PartialEq)]
pub struct HandPose {
    q_rad: HandVector,
    pub(crate) base_from_joint: [Transform; HAND_JOINTS],
    base_from_hand: Transform,
    base_from_tip: [Transform; FINGERS],
}

impl HandPose {
    /// The joint angles that this pose was computed from, radians.
    #[must_use]
    pub fn q_rad(&self) -> &HandVector {
        &self.q_rad
    }

    /// Origin of a joint, metres. `joint` counts within the hand, below [`HAND_JOINTS`].
    #[must_use]
    pub fn joint_origin_m(&self, joint: usize) -> Vector3<f64> {
        self.base_from_joint[joint].translation_m
    }

    /// Axis of a joint, unit length. `joint` counts within the hand, below [`HAND_JOINTS`].
    #[must_use]
    pub fn joint_axis(&self, joint: usize) -> Vector3<f64> {
        self.base_from_joint[joint].z_axis()
    }

    /// The hand link's frame: x is the hand's pointing direction, y the direction from finger 2 to finger 1.
    #[must_use]
    pub fn base_from_hand(&self) -> &Transform {
        &self.base_from_hand
    }

    /// The frame of each tip: origin in the centre of the dome's sphere, z = dome axis a, x = −u, y = u × a, where
    /// "up" u is −x of the hand at the straight pose, made normal to a.
    ///
    /// A point of the dome at polar angle θ and azimuth φ (`dome-41`: d = a·cosθ + sinθ·(y·cosφ + u·sinφ)) therefore
    /// lies along (−sinθ·sinφ, sinθ·cosφ, cosθ) in this frame.
    #[must_use]
    pub fn base_from_tip(&self) -> &[Transform; FINGERS] {
        &self.base_from_tip
    }

    /// Centre of a dome's sphere, metres. `finger` is 0 or 1.
    #[must_use]
    pub fn tip_m(&self, finger: usize) -> Vector3<f64> {
        self.base_from_tip[finger].translation_m
    }

    /// Direction from a dome's centre through its pole, unit length. `finger` is 0 or 1.
    #[must_use]
    pub fn dome_axis(&self, finger: usize) -> Vector3<f64> {
        self.base_from_tip[finger].z_axis()
    }

    /// The hand's pointing direction, unit length.
    #[must_use]
    pub fn hand_axis(&self) -> Vector3<f64> {
        self.base_from_hand.x_axis()
    }
}

impl HandModel {
    /// Forward kinematics. A joint angle that is not finite makes the frames behind it not finite, nothing else.
    #[must_use]
    pub fn forward(&self, q_rad: &HandVector) -> HandPose {
        let mut base_from_joint = [Transform::IDENTITY; HAND_JOINTS];
        for joint in 0..HAND_JOINTS {
            let mount = &self.parent_from_joint[joint];
            let at_zero = match PARENT[joint] {
                None => *mount,
                Some(parent) => base_from_joint[parent].then(mount),
            };
            base_from_joint[joint] = at_zero.turned_about_z(q_rad[joint]);
        }
        let tip = |finger: usize| {
            base_from_joint[finger_root(finger) + FINGER_JOINTS - 1]
                .then(&self.distal_from_tip[finger])
        };
        HandPose {
            q_rad: *q_rad,
            base_from_hand: base_from_joint[ARM_JOINTS - 1].then(&self.wrist_from_hand),
            base_from_tip: [tip(0), tip(1)],
            base_from_joint,
        }
    }
}

impl HandModel {
    /// The collision bodies of the hand at a pose, base frame.
    #[must_use]
    pub fn capsules(&self, pose: &HandPose) -> Capsules {
        self.capsules.placed(&pose.base_from_joint)
    }
}
