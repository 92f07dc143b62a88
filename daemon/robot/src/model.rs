//! Model of one arm with its hand, in fixed size: a tree of joints with limits and mounting
//! transforms.

use crate::grasp_sides::GraspSide;
use core::ops::Range;

use nalgebra::Vector3;

use crate::capsule::Capsules;
use crate::grasp_sides::GraspSides;
use crate::joint::Joint;
use crate::name::Name;
use crate::side::HandSide;
use crate::sizes::{FINGERTIPS_MAX, FRAMES_MAX, HAND_JOINTS_MAX};
use crate::skin::Skin;
use crate::transform::Transform;
use crate::turning::Turning;
use crate::vector::HandVector;
use crate::workspace::Workspace;

/// One arm with its hand.
///
/// Order of its joints: the arm from the base on; drives that several fingers share; the joints of
/// finger 1, of finger 2 and so on. The first two groups are the *trunk*: they move more than one
/// fingertip.
///
/// Every moving joint of the URDF has a *frame*, including a mimicking joint, which has no
/// coordinate. The frame is the URDF's joint frame, turned so that its z is the joint's axis.
/// Forward kinematics then needs one motion along or about z per frame, for any axis of the URDF.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct HandModel {
    pub(crate) side: HandSide,
    pub(crate) joints: [Joint; HAND_JOINTS_MAX],
    pub(crate) joint_count: usize,
    pub(crate) arm_joints: usize,
    pub(crate) trunk_joints: usize,
    pub(crate) frames: [Frame; FRAMES_MAX],
    pub(crate) frame_count: usize,
    /// Link that carries the fingers.
    pub(crate) palm: Mounted,
    /// Direction of that link that points down in a grasp from above, in its own frame.
    pub(crate) pointing: Vector3<f64>,
    pub(crate) fingers: [Finger; FINGERTIPS_MAX],
    pub(crate) finger_count: usize,
    pub(crate) tip_radius_m: [f64; FINGERTIPS_MAX],
    pub(crate) skin: Skin,
    pub(crate) reference: HandVector,
    /// Per joint: true if it tilts its finger about the closing axis, like a wrist.
    pub(crate) tilts: [bool; HAND_JOINTS_MAX],
    pub(crate) turning: Turning,
    /// See [`HandModel::domes_tilt`].
    pub(crate) domes_tilt: bool,
    /// The fingertips cannot pass each other, but the wrist turns the hand about the vertical.
    pub(crate) turns_by_wrist: bool,
    /// The hand can shift and turn slightly at home.
    pub(crate) lateral_shift: bool,
    /// Home position and opening, from above, m.
    pub(crate) home_m: Vector3<f64>,
    pub(crate) home_opening_m: f64,
    /// Largest opening at home with both sides symmetric, m.
    pub(crate) max_opening_m: f64,
    /// Largest opening and closing speed of each finger, m/s.
    pub(crate) finger_speed_m_s: f64,
    /// Direction of the closing axis at home, radians.
    pub(crate) home_yaw_rad: f64,
    /// Default object position: x and y, m.
    pub(crate) object_m: [f64; 2],
    pub(crate) workspace: Option<Workspace>,
    /// Collision capsules, each in the frame that moves it.
    pub(crate) capsules: Capsules,
}

/// Frame of one moving joint of the URDF: it moves along or about its z axis.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Frame {
    /// Parent frame, of a smaller index; `None` for the base.
    pub parent: Option<usize>,
    /// Transform from the parent to this frame without motion.
    pub parent_from_frame: Transform,
    /// Cause of the motion.
    pub mover: Mover,
    /// Motion at coordinate zero, rad or m.
    pub offset: f64,
}

/// Cause of a frame's motion.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Mover {
    /// Frame, for [`crate::HandPose::frame_axis`] and [`crate::HandPose::frame_origin_m`].
    pub frame: usize,
    /// Joint whose coordinate moves the frame, counted within the hand.
    pub joint: usize,
    /// Motion per motion of that joint: 1, or the multiplier of a mimicking joint.
    pub ratio: f64,
    /// True if the frame slides along its axis instead of turning about it.
    pub slides: bool,
}

/// Part fixed to a frame or to the base.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Mounted {
    /// Frame that moves the part; `None` for the base.
    pub frame: Option<usize>,
    /// Transform from that frame, or the base, to the part.
    pub frame_from_link: Transform,
}

/// One fingertip and its movers.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct Finger {
    /// Name of the link that carries the tip frame.
    pub(crate) link: Name,
    /// Grasp side, 0 or 1.
    pub(crate) side: GraspSide,
    pub(crate) tip: Mounted,
    /// First joint of the finger, and number of joints.
    pub(crate) first_joint: usize,
    pub(crate) joint_count: usize,
    /// Per frame: true if it moves this tip.
    pub(crate) moved_by: [bool; FRAMES_MAX],
    /// Offset from the middle of its side, along z × n for a hand that points down, m.
    pub(crate) offset_m: f64,
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
            side: GraspSide::First,
            tip: Mounted::ON_BASE,
            first_joint: 0,
            joint_count: 0,
            moved_by: [false; FRAMES_MAX],
            offset_m: 0.0,
        }
    }
}

impl HandModel {
    /// Creates the missing hand of a one-handed robot: no joints, no fingers.
    #[must_use]
    pub fn absent(side: HandSide) -> HandModel {
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
            fingers: [Finger::none(); FINGERTIPS_MAX],
            finger_count: 0,
            tip_radius_m: [0.0; FINGERTIPS_MAX],
            skin: Skin::DOME_41,
            reference: HandVector::zeros(0),
            tilts: [false; HAND_JOINTS_MAX],
            turning: Turning::default(),
            domes_tilt: false,
            turns_by_wrist: false,
            lateral_shift: false,
            home_m: Vector3::zeros(),
            home_opening_m: 0.0,
            max_opening_m: 0.0,
            finger_speed_m_s: 0.0,
            home_yaw_rad: 0.0,
            object_m: [0.0; 2],
            workspace: None,
            capsules: Capsules::new(),
        }
    }

    /// Returns true if the robot has this hand.
    #[must_use]
    pub fn is_present(&self) -> bool {
        self.finger_count > 0
    }

    /// Returns left or right.
    #[must_use]
    pub fn side(&self) -> HandSide {
        self.side
    }

    /// Returns the joints of the hand in order.
    #[must_use]
    pub fn joints(&self) -> &[Joint] {
        &self.joints[..self.joint_count]
    }

    /// Returns the indices of the arm's joints.
    #[must_use]
    pub fn arm_joints(&self) -> Range<usize> {
        0..self.arm_joints
    }

    /// Returns the indices of the joints that move more than one fingertip: those of the arm, then
    /// drives that fingers share.
    #[must_use]
    pub fn trunk_joints(&self) -> Range<usize> {
        0..self.trunk_joints
    }

    /// Returns the indices of the joints that move only this fingertip.
    #[must_use]
    pub fn finger_joints(&self, finger: usize) -> Range<usize> {
        let finger = &self.fingers[finger];
        finger.first_joint..finger.first_joint + finger.joint_count
    }

    /// Returns the joint ranges of the arm, of shared drives and of each finger.
    pub fn limbs(&self) -> impl Iterator<Item = Range<usize>> + '_ {
        let fingers = (0..self.finger_count).map(|finger| self.finger_joints(finger));
        let shared = self.arm_joints..self.trunk_joints;
        [self.arm_joints(), shared].into_iter().chain(fingers)
    }

    /// Returns true if a joint after the arm moves a fingertip of this grasp side.
    #[must_use]
    pub fn drives(&self, joint: usize, side: GraspSide) -> bool {
        let moves = |finger: usize| self.movers(finger).any(|mover| mover.joint == joint);
        joint >= self.arm_joints && self.fingertips_of(side).any(moves)
    }

    /// Returns the number of fingertips.
    #[must_use]
    pub fn fingertip_count(&self) -> usize {
        self.finger_count
    }

    /// Returns the grasp side of a fingertip.
    #[must_use]
    pub fn grasp_side(&self, finger: usize) -> GraspSide {
        self.fingers[finger].side
    }

    /// Returns the fingertips of a grasp side.
    pub fn fingertips_of(&self, side: GraspSide) -> impl Iterator<Item = usize> + '_ {
        let presses = move |finger: &usize| self.grasp_side(*finger) == side;
        (0..self.finger_count).filter(presses)
    }

    /// Returns the grasp sides of all fingertips.
    #[must_use]
    pub fn grasp_sides(&self) -> GraspSides {
        GraspSides::new((0..self.finger_count).map(|finger| self.grasp_side(finger)))
    }

    /// Returns the number of fingertips of the side with fewer. The largest grip force is this
    /// number times the limit of one fingertip.
    #[must_use]
    pub fn opposed_tips(&self) -> usize {
        let of_side = |side| self.fingertips_of(side).count();
        GraspSide::BOTH.into_iter().map(of_side).min().unwrap_or(0)
    }

    /// Returns the names of the links that carry the tip frames.
    pub fn tip_links(&self) -> impl Iterator<Item = &str> {
        self.fingers[..self.finger_count]
            .iter()
            .map(|finger| finger.link.as_str())
    }

    /// Returns the movers of a fingertip, from the base on.
    pub fn movers(&self, finger: usize) -> impl Iterator<Item = &Mover> {
        let frames = self.frames[..self.frame_count].iter();
        frames
            .zip(&self.fingers[finger].moved_by)
            .filter_map(|(frame, moves)| moves.then_some(&frame.mover))
    }

    /// Returns the number of moving frames.
    #[must_use]
    pub fn frame_count(&self) -> usize {
        self.frame_count
    }

    /// Returns the moving frames, each after its parent.
    #[must_use]
    pub fn frames(&self) -> &[Frame] {
        &self.frames[..self.frame_count]
    }

    /// Returns the mounting of each tip frame.
    pub fn tip_mounts(&self) -> impl Iterator<Item = &Mounted> {
        self.fingers[..self.finger_count]
            .iter()
            .map(|finger| &finger.tip)
    }

    /// Returns true if the hand can shift and turn slightly at home. A hand on a mere lift cannot.
    #[must_use]
    pub fn has_lateral_shift(&self) -> bool {
        self.lateral_shift
    }

    /// Returns the distance from each tip frame's origin to the middle of its sensing face, m: the
    /// radius of a dome.
    #[must_use]
    pub fn tip_radius_m(&self) -> &[f64] {
        &self.tip_radius_m[..self.finger_count]
    }

    /// Returns the tactile skin.
    #[must_use]
    pub fn skin(&self) -> &Skin {
        &self.skin
    }

    /// Returns the mean of a value over the fingertips of a side.
    pub fn mean_of_side(&self, side: GraspSide, value: impl FnMut(usize) -> f64) -> f64 {
        mean(self.fingertips_of(side).map(value))
    }

    /// Returns the longer of both sides' mean error vectors, m; 0 without fingertips.
    pub(crate) fn side_error_m(&self, error_m: impl Fn(usize) -> Vector3<f64>) -> f64 {
        GraspSide::BOTH.iter().fold(0.0_f64, |worst_m, &side| {
            let mean = |axis: usize| self.mean_of_side(side, |finger| error_m(finger)[axis]);
            worst_m.max(Vector3::new(mean(0), mean(1), mean(2)).norm())
        })
    }

    /// Returns the posture that the inverse kinematics prefers where the task leaves freedom,
    /// within the limits.
    #[must_use]
    pub fn reference(&self) -> &HandVector {
        &self.reference
    }

    /// Returns the servo stiffness of every joint, N·m/rad.
    #[must_use]
    pub fn stiffness(&self) -> HandVector {
        HandVector::from_fn(self.joint_count, |joint| self.joints[joint].stiffness)
    }

    /// Returns the joints that tilt their finger about the closing axis.
    pub(crate) fn tilting_joints(&self) -> impl Iterator<Item = usize> + '_ {
        (0..self.joint_count).filter(|joint| self.tilts[*joint])
    }

    /// Returns the joints that are the only one of their finger.
    pub(crate) fn lone_joints(&self) -> impl Iterator<Item = usize> + '_ {
        let fingers = self.fingers[..self.finger_count].iter();
        let lone = fingers.filter(|finger| finger.joint_count == 1);
        lone.map(|finger| finger.first_joint)
    }

    /// Returns the mean position of the joints that tilt the fingers, radians; 0 without such
    /// joints.
    #[must_use]
    pub fn root_rad(&self, q: &HandVector) -> f64 {
        let roots = self.tilting_joints();
        mean(roots.filter_map(|joint| q.get(joint).copied()))
    }

    /// Returns the home position: the point between the fingertips, base frame, metres.
    #[must_use]
    pub fn home_m(&self) -> Vector3<f64> {
        self.home_m
    }

    /// Returns the home opening: the distance between the poles of the domes, metres.
    #[must_use]
    pub fn home_opening_m(&self) -> f64 {
        self.home_opening_m
    }

    /// Returns the largest opening at home with both sides symmetric, metres.
    #[must_use]
    pub fn max_opening_m(&self) -> f64 {
        self.max_opening_m
    }

    /// Returns the speed at which each finger can open and close at home at any opening, m/s.
    #[must_use]
    pub fn finger_speed_m_s(&self) -> f64 {
        self.finger_speed_m_s
    }

    /// Returns true if the wrist turns caps because the fingertips cannot pass each other.
    #[must_use]
    pub fn turns_by_wrist(&self) -> bool {
        self.turns_by_wrist
    }

    /// Returns the direction of the closing axis at home, base frame, radians.
    #[must_use]
    pub fn home_yaw_rad(&self) -> f64 {
        self.home_yaw_rad
    }

    /// Returns the default object position: x and y, base frame, metres.
    #[must_use]
    pub fn object_m(&self) -> [f64; 2] {
        self.object_m
    }

    /// Returns the box to which the robot file limits grasps; `None` if reach is the only limit.
    #[must_use]
    pub fn workspace(&self) -> Option<&Workspace> {
        self.workspace.as_ref()
    }

    /// Returns the position of the first joint at zero, base frame, metres: the origin of bearings.
    #[must_use]
    pub fn shoulder_m(&self) -> Vector3<f64> {
        self.frames[0].parent_from_frame.translation_m
    }

    /// Returns the hand with longer links: the mounting of each frame and tip is lengthened along
    /// itself, m. Mountings of zero length stay. Simulates a robot that differs from its model.
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

    /// Returns true if every joint position is finite and within its limits.
    #[must_use]
    pub fn within_limits(&self, q: &HandVector) -> bool {
        let within = |(joint, &q): (&Joint, &f64)| q >= joint.lower && q <= joint.upper;
        self.joints().iter().zip(q.iter()).all(within)
    }
}

/// Returns the mean of values, 0 without values.
pub(crate) fn mean(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = values.fold((0.0, 0.0), |(sum, count), value| (sum + value, count + 1.0));
    if count > 0.0 { sum / count } else { 0.0 }
}
