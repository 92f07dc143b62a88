//! Forward kinematics of one hand: from joint positions to frames of joints, hand and fingertips.

use crate::grasp_sides::{GraspSide, PerSide};
use arrayvec::ArrayVec;
use nalgebra::Vector3;

use crate::capsule::Capsules;
use crate::model::{HandModel, Mounted};
use crate::sizes::{FINGERTIPS_MAX, FRAMES_MAX};
use crate::transform::Transform;
use crate::vector::HandVector;

/// Pose of one hand for one joint vector; all coordinates in the base frame.
///
/// [`HandModel::forward`] and [`HandModel::place`] are the only constructors, so frames and joint
/// positions always match.
#[derive(Clone, Debug, PartialEq)]
pub struct HandPose {
    q: HandVector,
    pub(crate) base_from_frame: ArrayVec<Transform, FRAMES_MAX>,
    base_from_hand: Transform,
    hand_axis: Vector3<f64>,
    base_from_tip: ArrayVec<Transform, FINGERTIPS_MAX>,
    side_m: PerSide<Vector3<f64>>,
}

impl HandPose {
    /// Joint positions of this pose.
    #[must_use]
    pub fn q(&self) -> &HandVector {
        &self.q
    }

    /// Origin of a moving frame, metres: see [`crate::Mover`].
    #[must_use]
    pub fn frame_origin_m(&self, frame: usize) -> Vector3<f64> {
        self.base_from_frame[frame].translation_m
    }

    /// Axis about or along which a frame moves, unit length: see [`crate::Mover`].
    #[must_use]
    pub fn frame_axis(&self, frame: usize) -> Vector3<f64> {
        self.base_from_frame[frame].z_axis()
    }

    /// Frame of the link that carries the fingers.
    #[must_use]
    pub fn base_from_hand(&self) -> &Transform {
        &self.base_from_hand
    }

    /// The frame of each tip: origin in the centre of the dome's sphere, z = dome axis a, x = −u, y
    /// = u × a, where "up" u is against the hand's pointing direction at the straight pose, made
    /// normal to a.
    ///
    /// A point of the dome at polar angle θ and azimuth φ (`dome-41`: d = a·cosθ + sinθ·(y·cosφ +
    /// u·sinφ)) therefore lies along (−sinθ·sinφ, sinθ·cosφ, cosθ) in this frame.
    #[must_use]
    pub fn base_from_tip(&self) -> &[Transform] {
        &self.base_from_tip
    }

    /// Centre of a dome's sphere, metres.
    #[must_use]
    pub fn tip_m(&self, finger: usize) -> Vector3<f64> {
        self.base_from_tip[finger].translation_m
    }

    /// Direction from a dome's centre through its pole, unit length.
    #[must_use]
    pub fn dome_axis(&self, finger: usize) -> Vector3<f64> {
        self.base_from_tip[finger].z_axis()
    }

    /// Mean of the dome centres of one grasp side, metres.
    #[must_use]
    pub fn side_m(&self, side: GraspSide) -> Vector3<f64> {
        self.side_m[side]
    }

    /// Midpoint between the grasp sides, metres.
    #[must_use]
    pub fn middle_m(&self) -> Vector3<f64> {
        (self.side_m[GraspSide::First] + self.side_m[GraspSide::Second]) / 2.0
    }

    /// Vector from the second to the first grasp side, metres.
    #[must_use]
    pub fn across_m(&self) -> Vector3<f64> {
        self.side_m[GraspSide::First] - self.side_m[GraspSide::Second]
    }

    /// The hand's pointing direction, unit length.
    #[must_use]
    pub fn hand_axis(&self) -> Vector3<f64> {
        self.hand_axis
    }
}

impl HandModel {
    /// Computes the pose. A joint position that is not finite makes only the frames behind it not
    /// finite; a missing one counts as 0. Inlined: a return would copy the pose.
    #[must_use]
    #[inline]
    pub fn forward(&self, q: &HandVector) -> HandPose {
        // Each field is set alone. A copy of a constant would copy the storage of unused frames
        // too.
        let mut pose = HandPose {
            q: *q,
            base_from_frame: ArrayVec::new(),
            base_from_hand: Transform::IDENTITY,
            hand_axis: Vector3::zeros(),
            base_from_tip: ArrayVec::new(),
            side_m: PerSide::repeat(Vector3::zeros()),
        };
        self.compute(&mut pose, q);
        pose
    }

    /// Computes the pose of these joint positions in place; does nothing if the pose already has
    /// them.
    pub fn place(&self, pose: &mut HandPose, q: &HandVector) {
        let same = |(a, b): (&f64, &f64)| a.to_bits() == b.to_bits();
        let stays = pose.q.len() == q.len() && pose.q.iter().zip(q.iter()).all(same);
        if !stays {
            self.compute(pose, q);
        }
    }

    fn compute(&self, pose: &mut HandPose, q: &HandVector) {
        pose.q = *q;
        let base_from_frame = &mut pose.base_from_frame;
        base_from_frame.clear();
        for frame in &self.frames[..self.frame_count] {
            let mount = &frame.parent_from_frame;
            let at_zero = match frame.parent {
                None => *mount,
                Some(parent) => base_from_frame[parent].then(mount),
            };
            let coordinate = q.get(frame.mover.joint).copied().unwrap_or(0.0);
            let motion = frame.mover.ratio * coordinate + frame.offset;
            base_from_frame.push(if frame.mover.slides {
                at_zero.moved_along_z(motion)
            } else {
                at_zero.turned_about_z(motion)
            });
        }
        let place = |mounted: &Mounted| match mounted.frame {
            None => mounted.frame_from_link,
            Some(frame) => base_from_frame[frame].then(&mounted.frame_from_link),
        };
        pose.base_from_hand = place(&self.palm);
        pose.hand_axis = pose.base_from_hand.rotation * self.pointing;
        pose.base_from_tip.clear();
        for finger in &self.fingers[..self.finger_count] {
            pose.base_from_tip.push(place(&finger.tip));
        }
        pose.side_m = PerSide::from_fn(|side| self.side_middle_m(side, &pose.base_from_tip));
    }

    /// Mean of the tips of one grasp side, metres.
    fn side_middle_m(&self, side: GraspSide, base_from_tip: &[Transform]) -> Vector3<f64> {
        let tips_m = self.fingertips_of(side);
        let tips_m = tips_m.map(|finger| base_from_tip[finger].translation_m);
        let (sum_m, count) = tips_m.fold((Vector3::zeros(), 0.0), |(sum_m, count), tip_m| {
            (sum_m + tip_m, count + 1.0)
        });
        if count > 0.0 { sum_m / count } else { sum_m }
    }

    /// Returns the height of the lowest point of the centre lines of the bodies that carry the
    /// fingers, base frame, m; infinity without such bodies. Radii are ignored: a capsule around a
    /// flat palm reaches far below it.
    #[must_use]
    pub fn lowest_of_palm_m(&self, pose: &HandPose) -> f64 {
        let capsules = self.capsules(pose);
        let of_palm = capsules.moved_by(self.palm.frame);
        of_palm.fold(f64::INFINITY, |lowest_m, body| {
            lowest_m.min(body.a_m.z.min(body.b_m.z))
        })
    }

    /// Returns the height from the closing point of the fingertips at the reference posture to the
    /// palm, m: the space for an object. See [`HandModel::lowest_of_palm_m`].
    #[must_use]
    pub fn room_over_tips_m(&self) -> f64 {
        let pose = self.forward(&self.reference);
        let middle_m = pose.middle_m();
        self.lowest_of_palm_m(&pose) - middle_m.z
    }

    /// Returns the collision bodies of the hand at a pose, base frame.
    #[must_use]
    pub fn capsules(&self, pose: &HandPose) -> Capsules {
        self.capsules.placed(&pose.base_from_frame)
    }
}
