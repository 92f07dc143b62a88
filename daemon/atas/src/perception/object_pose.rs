//! Where what a hand presses on stands: felt by the fingertips, not told by anybody.
//!
//! ```text
//!      c_1 ●──n_1──▶        ◀──n_2──● c_2     Every fingertip presses at a contact c and feels the face's normal n there,
//!                    ✕                        into the object. The object's middle is met from each contact by going as far
//!                 middle                      along its normal; that distance follows from the contacts themselves.
//! ```
//!
//! On two parallel faces the middle lies between the contacts, and the normals tell how the object is turned; along the faces
//! nothing tells where it ends. On a round object the normals meet in its axis. Fingertips whose normal is always that of their own
//! face (flat pads, single elements) feel the middle between the sides and no turn.

use super::Percept;
use crate::limits::PATCH_FLOOR_N;
use nalgebra::Vector2;
use robot_model::{HandModel, HandPose, VIRTUAL_FINGERS};

/// Least square of the distance between the normals of both sides, of unit vectors, by which a distance can be told (ours: the
/// sides then still face each other within 90°).
const FACING: f64 = 2.0;

/// Where an object stands against the hand that presses on it, in the horizontal plane.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct ObjectPose {
    /// From the middle between the sides' fingertips to the middle of the object, base frame, m.
    pub off_m: Vector2<f64>,
    /// Direction of the line through both sides' fingertips, from the second side to the first, base frame, unit length.
    pub closing_axis: Vector2<f64>,
    /// From the line through both sides' fingertips to the normal of the object's faces, anticlockwise seen from above, rad.
    pub turn_rad: f64,
}

impl ObjectPose {
    /// What the fingertips of a hand at `measured` feel; `None` unless both sides press clearly. Where not
    /// every fingertip of a side does, nothing is known of the place along the faces.
    #[must_use]
    pub fn felt(hand: &HandModel, measured: &HandPose, percept: &Percept) -> Option<Self> {
        let mut sides = [Contacts::default(); VIRTUAL_FINGERS];
        let mut all_press = true;
        for (index, finger) in percept.fingers[..hand.finger_count()].iter().enumerate() {
            if !finger.in_contact || finger.normal_n <= PATCH_FLOOR_N {
                all_press = false;
                continue;
            }
            let tip = &measured.base_from_tip()[index];
            let normal = (tip.rotation * finger.patch_normal).xy();
            let contact_m = tip.translation_m.xy() + normal * hand.tip_radius_m()[index];
            sides[hand.virtual_finger(index)].add(contact_m, normal);
        }
        let [first, second] = sides.map(Contacts::mean);
        let ((first_m, first), (second_m, second)) = (first?, second?);
        let facing = first - second;
        if facing.norm_squared() < FACING {
            return None;
        }
        let deep_m = -(first_m - second_m).dot(&facing) / facing.norm_squared();
        let middle_m = (first_m + second_m + (first + second) * deep_m) / 2.0;
        let line = (measured.side_m(0) - measured.side_m(1)).xy().normalize();
        let off_m = middle_m - ((measured.side_m(0) + measured.side_m(1)) / 2.0).xy();
        Some(Self {
            off_m: if all_press {
                off_m
            } else {
                line * line.dot(&off_m)
            },
            closing_axis: line,
            turn_rad: libm::atan2(facing.perp(&line), -facing.dot(&line)),
        })
    }
}

/// Sums over the fingertips of one side that press.
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

    /// Their middle, m, and their mean normal; `None` if none presses.
    fn mean(self) -> Option<(Vector2<f64>, Vector2<f64>)> {
        (self.count > 0.0).then(|| (self.contact_m / self.count, self.normal / self.count))
    }
}
