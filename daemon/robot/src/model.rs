//! A hand with its arm as data of fixed size: a tree of joints, with limits and mounting transforms.

use core::ops::Range;

use nalgebra::Vector3;

use crate::capsule::Capsules;
use crate::joint::Joint;
use crate::name::Name;
use crate::side::Side;
use crate::sizes::{FINGERS_MAX, FRAMES_MAX, HAND_JOINTS_MAX, VIRTUAL_FINGERS};
use crate::skin::Skin;
use crate::transform::Transform;
use crate::turning::Turning;
use crate::vector::HandVector;
use crate::workspace::Workspace;

/// One arm with its hand.
///
/// Its joints in order: those of the arm from the base on, then drives that several fingers share, then those that move
/// finger 1 alone, then finger 2 and so on. The first two groups are the *trunk*: what moves more than one fingertip.
///
/// Every moving joint of the URDF has a *frame*, also one that mimics another and so has no coordinate of its own. It is the
/// URDF's joint frame turned so that its z is the joint's axis: forward kinematics then needs one motion along or about z
/// per frame whatever axes the URDF chose.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct HandModel {
    pub(crate) side: Side,
    pub(crate) joints: [Joint; HAND_JOINTS_MAX],
    pub(crate) joint_count: usize,
    pub(crate) arm_joints: usize,
    pub(crate) trunk_joints: usize,
    pub(crate) frames: [Frame; FRAMES_MAX],
    pub(crate) frame_count: usize,
    /// The link that carries the fingers.
    pub(crate) palm: Mounted,
    /// Direction of that link that points down in a grasp from above, in its own frame.
    pub(crate) pointing: Vector3<f64>,
    pub(crate) fingers: [Finger; FINGERS_MAX],
    pub(crate) finger_count: usize,
    pub(crate) tip_radius_m: [f64; FINGERS_MAX],
    pub(crate) skin: Skin,
    pub(crate) reference_rad: HandVector,
    /// Per joint: whether it tilts its finger about the closing axis, as a wrist would.
    pub(crate) tilts: [bool; HAND_JOINTS_MAX],
    pub(crate) turning: Turning,
    /// See [`HandModel::domes_tilt`].
    pub(crate) domes_tilt: bool,
    /// Its fingertips cannot pass each other, but its wrist turns it about the vertical.
    pub(crate) turns_by_wrist: bool,
    /// Whether it can shift and turn a little where it rests.
    pub(crate) moves_aside: bool,
    /// Where the hand rests, from above, and how far open, m.
    pub(crate) home_m: Vector3<f64>,
    pub(crate) home_opening_m: f64,
    /// How far open it can be where it rests, both sides alike, m.
    pub(crate) widest_m: f64,
    /// Speed at which each finger opens and closes at most, m/s.
    pub(crate) finger_speed_m_s: f64,
    /// Direction of the closing axis there, radians.
    pub(crate) home_yaw_rad: f64,
    /// Where objects stand that nobody placed: x and y, m.
    pub(crate) object_m: [f64; 2],
    pub(crate) workspace: Option<Workspace>,
    /// Collision capsules, each in the frame that moves it.
    pub(crate) capsules: Capsules,
}

/// The frame of one moving joint of the URDF.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct Frame {
    /// The frame that carries it, of a smaller index; `None` for the base.
    pub(crate) parent: Option<usize>,
    /// Transform from that frame to this one at zero.
    pub(crate) parent_from_frame: Transform,
    pub(crate) mover: Mover,
    /// Motion at coordinate zero.
    pub(crate) offset: f64,
}

/// What moves a frame.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Mover {
    /// Its frame, for [`crate::HandPose::frame_axis`] and [`crate::HandPose::frame_origin_m`].
    pub frame: usize,
    /// The joint whose coordinate moves it, counted within the hand.
    pub joint: usize,
    /// Motion per motion of that joint: 1, or the multiplier of a joint that mimics it.
    pub ratio: f64,
    /// Whether it slides along its axis instead of turning about it.
    pub slides: bool,
}

/// Something fixed to a frame, or to the base.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct Mounted {
    pub(crate) frame: Option<usize>,
    pub(crate) frame_from_link: Transform,
}

/// One fingertip and what moves it.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct Finger {
    /// Name of the link that carries the tip frame.
    pub(crate) link: Name,
    /// The side from which it presses, 0 or 1.
    pub(crate) virtual_finger: usize,
    pub(crate) tip: Mounted,
    /// Its own joints: the first, and how many.
    pub(crate) first_joint: usize,
    pub(crate) joint_count: usize,
    /// Per frame, whether it moves this tip.
    pub(crate) moved_by: [bool; FRAMES_MAX],
    /// How far it stands beside the middle of its side, along z × n for a hand that points down, m.
    pub(crate) beside_m: f64,
}

impl Frame {
    pub(crate) const NONE: Frame = Frame {
        parent: None,
        parent_from_frame: Transform::IDENTITY,
        mover: Mover {
            frame: 0,
            joint: 0,
            ratio: 0.0,
            slides: false,
        },
        offset: 0.0,
    };
}

impl Mounted {
    pub(crate) const ON_BASE: Mounted = Mounted {
        frame: None,
        frame_from_link: Transform::IDENTITY,
    };
}

impl Finger {
    pub(crate) fn none() -> Finger {
        Finger {
            link: Name::default(),
            virtual_finger: 0,
            tip: Mounted::ON_BASE,
            first_joint: 0,
            joint_count: 0,
            moved_by: [false; FRAMES_MAX],
            beside_m: 0.0,
        }
    }
}

impl HandModel {
    /// The hand that a one-handed robot has not got: no joints, no fingers.
    #[must_use]
    pub fn absent(side: Side) -> HandModel {
        HandModel {
            side,
            joints: [Joint::default(); HAND_JOINTS_MAX],
            joint_count: 0,
            arm_joints: 0,
            trunk_joints: 0,
            frames: [Frame::NONE; FRAMES_MAX],
            frame_count: 0,
            palm: Mounted::ON_BASE,
            pointing: -Vector3::z(),
            fingers: [Finger::none(); FINGERS_MAX],
            finger_count: 0,
            tip_radius_m: [0.0; FINGERS_MAX],
            skin: Skin::DOME_41,
            reference_rad: HandVector::zeros(0),
            tilts: [false; HAND_JOINTS_MAX],
            turning: Turning::default(),
            domes_tilt: false,
            turns_by_wrist: false,
            moves_aside: false,
            home_m: Vector3::zeros(),
            home_opening_m: 0.0,
            widest_m: 0.0,
            finger_speed_m_s: 0.0,
            home_yaw_rad: 0.0,
            object_m: [0.0; 2],
            workspace: None,
            capsules: Capsules::new(),
        }
    }

    /// Whether the robot has this hand.
    #[must_use]
    pub fn is_present(&self) -> bool {
        self.finger_count > 0
    }

    /// Which side this is.
    #[must_use]
    pub fn side(&self) -> Side {
        self.side
    }

    /// The joints of the hand in order.
    #[must_use]
    pub fn joints(&self) -> &[Joint] {
        &self.joints[..self.joint_count]
    }

    /// Positions of the arm's joints in the hand's order.
    #[must_use]
    pub fn arm_joints(&self) -> Range<usize> {
        0..self.arm_joints
    }

    /// Positions of the joints that move more than one fingertip: the arm's, then drives that fingers share.
    #[must_use]
    pub fn trunk_joints(&self) -> Range<usize> {
        0..self.trunk_joints
    }

    /// Positions of the joints that move one fingertip alone.
    #[must_use]
    pub fn finger_joints(&self, finger: usize) -> Range<usize> {
        let finger = &self.fingers[finger];
        finger.first_joint..finger.first_joint + finger.joint_count
    }

    /// The joints of the arm, those that fingers share, and each finger's own.
    pub fn limbs(&self) -> impl Iterator<Item = Range<usize>> + '_ {
        let fingers = (0..self.finger_count).map(|finger| self.finger_joints(finger));
        let shared = self.arm_joints..self.trunk_joints;
        [self.arm_joints(), shared].into_iter().chain(fingers)
    }

    /// Whether a joint behind the arm moves a fingertip of one side.
    #[must_use]
    pub fn drives(&self, joint: usize, virtual_finger: usize) -> bool {
        let moves = |finger: usize| self.movers(finger).any(|mover| mover.joint == joint);
        joint >= self.arm_joints && self.fingers_of(virtual_finger).any(moves)
    }

    /// How many fingertips the hand has.
    #[must_use]
    pub fn finger_count(&self) -> usize {
        self.finger_count
    }

    /// The side from which a fingertip presses, 0 or 1: see [`VIRTUAL_FINGERS`].
    #[must_use]
    pub fn virtual_finger(&self, finger: usize) -> usize {
        self.fingers[finger].virtual_finger
    }

    /// The fingertips that press from one side.
    pub fn fingers_of(&self, virtual_finger: usize) -> impl Iterator<Item = usize> + '_ {
        let presses = move |finger: &usize| self.virtual_finger(*finger) == virtual_finger;
        (0..self.finger_count).filter(presses)
    }

    /// Fingertips of the side that has fewer: as many times as one bears, the hand may press.
    #[must_use]
    pub fn opposed_tips(&self) -> usize {
        let of_side = |side| self.fingers_of(side).count();
        (0..VIRTUAL_FINGERS).map(of_side).min().unwrap_or(0)
    }

    /// Names of the links that carry the tip frames.
    pub fn tip_links(&self) -> impl Iterator<Item = &str> {
        self.fingers[..self.finger_count]
            .iter()
            .map(|finger| finger.link.as_str())
    }

    /// What moves a fingertip, from the base on.
    pub fn movers(&self, finger: usize) -> impl Iterator<Item = &Mover> {
        let frames = self.frames[..self.frame_count].iter();
        frames
            .zip(&self.fingers[finger].moved_by)
            .filter_map(|(frame, moves)| moves.then_some(&frame.mover))
    }

    /// Frames that move.
    #[must_use]
    pub fn frame_count(&self) -> usize {
        self.frame_count
    }

    /// Whether the hand can shift and turn a little where it rests: one on a lift alone cannot.
    #[must_use]
    pub fn moves_aside(&self) -> bool {
        self.moves_aside
    }

    /// From each tip frame's origin to the middle of its sensing face, m: the radius of a dome.
    #[must_use]
    pub fn tip_radius_m(&self) -> &[f64] {
        &self.tip_radius_m[..self.finger_count]
    }

    /// What its fingertips feel with.
    #[must_use]
    pub fn skin(&self) -> &Skin {
        &self.skin
    }

    /// Mean of a value over the fingertips that press from one side.
    pub fn mean_of_side(&self, virtual_finger: usize, value: impl FnMut(usize) -> f64) -> f64 {
        mean(self.fingers_of(virtual_finger).map(value))
    }

    /// The longer of both sides' mean of a vector of each fingertip, m; 0 without fingertips.
    pub(crate) fn side_error_m(&self, error_m: impl Fn(usize) -> Vector3<f64>) -> f64 {
        (0..VIRTUAL_FINGERS).fold(0.0_f64, |worst_m, side| {
            let mean = |axis: usize| self.mean_of_side(side, |finger| error_m(finger)[axis]);
            worst_m.max(Vector3::new(mean(0), mean(1), mean(2)).norm())
        })
    }

    /// The posture that the inverse kinematics prefers where the task leaves freedom, radians, inside the limits.
    #[must_use]
    pub fn reference_rad(&self) -> &HandVector {
        &self.reference_rad
    }

    /// Stiffness of every joint's servo, N·m/rad.
    #[must_use]
    pub fn stiffness_n_m_rad(&self) -> HandVector {
        HandVector::from_fn(self.joint_count, |joint| {
            self.joints[joint].stiffness_n_m_rad
        })
    }

    /// Joints that tilt their finger about the closing axis.
    pub(crate) fn tilting_joints(&self) -> impl Iterator<Item = usize> + '_ {
        (0..self.joint_count).filter(|joint| self.tilts[*joint])
    }

    /// Joints that are their finger's only one.
    pub(crate) fn lone_joints(&self) -> impl Iterator<Item = usize> + '_ {
        let fingers = self.fingers[..self.finger_count].iter();
        let lone = fingers.filter(|finger| finger.joint_count == 1);
        lone.map(|finger| finger.first_joint)
    }

    /// Mean angle of the joints that tilt the fingers, radians; 0 if the hand has none.
    #[must_use]
    pub fn root_rad(&self, q_rad: &HandVector) -> f64 {
        let roots = self.tilting_joints();
        mean(roots.filter_map(|joint| q_rad.get(joint).copied()))
    }

    /// Where the hand rests: the point between its fingertips, base frame, metres.
    #[must_use]
    pub fn home_m(&self) -> Vector3<f64> {
        self.home_m
    }

    /// Distance between the poles of its domes where it rests, metres.
    #[must_use]
    pub fn home_opening_m(&self) -> f64 {
        self.home_opening_m
    }

    /// Greatest distance between the poles of its domes where it rests, both sides alike, metres.
    #[must_use]
    pub fn widest_m(&self) -> f64 {
        self.widest_m
    }

    /// Speed that its joints allow each finger to open and close with where it rests, however far open, m/s.
    #[must_use]
    pub fn finger_speed_m_s(&self) -> f64 {
        self.finger_speed_m_s
    }

    /// Whether it turns a cap by its wrist, because its fingertips cannot pass each other.
    #[must_use]
    pub fn turns_by_wrist(&self) -> bool {
        self.turns_by_wrist
    }

    /// Direction of its closing axis where it rests, base frame, radians.
    #[must_use]
    pub fn home_yaw_rad(&self) -> f64 {
        self.home_yaw_rad
    }

    /// Where objects stand before it that nobody placed: x and y, base frame, metres.
    #[must_use]
    pub fn object_m(&self) -> [f64; 2] {
        self.object_m
    }

    /// The box that its robot file keeps grasps to; `None` if the hand may go wherever it has a posture.
    #[must_use]
    pub fn workspace(&self) -> Option<&Workspace> {
        self.workspace.as_ref()
    }

    /// Position of the first joint at zero, in the base frame, metres: bearings of this arm are seen from here.
    #[must_use]
    pub fn shoulder_m(&self) -> Vector3<f64> {
        self.frames[0].parent_from_frame.translation_m
    }

    /// The same hand with longer links: the mounting of each frame, and of each tip, longer by so much along itself, m.
    /// What is mounted in place stays there. For simulating a robot that is not quite as its model says.
    #[must_use]
    pub fn with_longer_links(&self, links_m: &[f64], tips_m: &[f64]) -> Self {
        let mut hand = *self;
        let links = hand.frames.iter_mut().map(|it| &mut it.parent_from_frame);
        let tips = hand
            .fingers
            .iter_mut()
            .map(|it| &mut it.tip.frame_from_link);
        for (mounting, by_m) in links.zip(links_m).chain(tips.zip(tips_m)) {
            let along = mounting.translation_m.try_normalize(0.0);
            mounting.translation_m += along.unwrap_or_default() * *by_m;
        }
        hand
    }

    /// Whether every joint is finite and inside its position limits (limits included).
    #[must_use]
    pub fn within_limits(&self, q_rad: &HandVector) -> bool {
        let within = |(joint, &q): (&Joint, &f64)| q >= joint.lower_rad && q <= joint.upper_rad;
        self.joints().iter().zip(q_rad.iter()).all(within)
    }
}

/// The mean of some values, 0 of none.
pub(crate) fn mean(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = values.fold((0.0, 0.0), |(sum, count), value| (sum + value, count + 1.0));
    if count > 0.0 { sum / count } else { 0.0 }
}
