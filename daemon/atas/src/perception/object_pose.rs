//! Object pose relative to the hand, estimated from the fingertip contacts.
//!
//! ```text
//!      c_1 ●──n_1──▶        ◀──n_2──● c_2
//!                    ✕
//!                 centre
//! ```
//!
//! Every fingertip has a contact c and an inward face normal n. The centre lies at the same
//! distance along each normal; the contacts determine this distance.
//!
//! On two parallel faces, the centre lies between the contacts, the normals give the yaw, and the
//! position along the faces is unknown. On a round object the normals meet in its axis. Fingertips
//! with a fixed patch normal (flat pads, single elements) give the centre between the sides and no
//! yaw.

use super::Percept;
use crate::limits::PATCH_FLOOR_N;
use nalgebra::Vector2;
use robot_model::{HandModel, HandPose, PerSide};

/// Smallest squared distance between the unit normals of both sides (design choice: the sides face
/// each other within 90°).
const FACING_MIN: f64 = 2.0;

/// Horizontal pose of an object relative to the pressing hand.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct ObjectPose {
    /// Offset from the midpoint of both sides to the object's centre, base frame, m.
    pub offset_m: Vector2<f64>,
    /// Direction from the second side to the first, base frame, unit length.
    pub closing_axis: Vector2<f64>,
    /// Angle from `closing_axis` to the normal of the object's faces, anticlockwise from above,
    /// rad.
    pub yaw_error_rad: f64,
}

impl ObjectPose {
    /// Estimates the pose at the measured hand pose; `None` unless both sides press clearly. Unless
    /// every fingertip presses, the offset along the faces is zero.
    #[must_use]
    pub fn estimate(hand: &HandModel, measured: &HandPose, percept: &Percept) -> Option<Self> {
        let mut sides = PerSide::repeat(Contacts::default());
        let mut all_press = true;
        for (index, finger) in percept.fingertips[..hand.fingertip_count()]
            .iter()
            .enumerate()
        {
            if !finger.in_contact || finger.normal_n <= PATCH_FLOOR_N {
                all_press = false;
                continue;
            }
            let tip = &measured.base_from_tip()[index];
            let normal = (tip.rotation * finger.patch_normal).xy();
            let contact_m = tip.translation_m.xy() + normal * hand.tip_radius_m()[index];
            sides[hand.grasp_side(index)].add(contact_m, normal);
        }
        let [first, second] = sides.map(Contacts::mean).into_array();
        let ((first_m, first), (second_m, second)) = (first?, second?);
        let facing = first - second;
        if facing.norm_squared() < FACING_MIN {
            return None;
        }
        let deep_m = -(first_m - second_m).dot(&facing) / facing.norm_squared();
        let middle_m = (first_m + second_m + (first + second) * deep_m) / 2.0;
        let line = measured.across_m().xy().normalize();
        let off_m = middle_m - measured.middle_m().xy();
        Some(Self {
            offset_m: if all_press {
                off_m
            } else {
                line * line.dot(&off_m)
            },
            closing_axis: line,
            yaw_error_rad: libm::atan2(facing.perp(&line), -facing.dot(&line)),
        })
    }
}

/// Sums over the pressing fingertips of one side.
#[derive(Clone, Copy, Default)]
struct Contacts {
    contact_m: Vector2<f64>,
    normal: Vector2<f64>,
    count: f64,
}

impl Contacts {
    fn add(&mut self, contact_m: Vector2<f64>, normal: Vector2<f64>) {
        self.contact_m += contact_m;
        self.normal += normal;
        self.count += 1.0;
    }

    fn mean(self) -> Option<(Vector2<f64>, Vector2<f64>)> {
        (self.count > 0.0).then(|| (self.contact_m / self.count, self.normal / self.count))
    }
}
