//! Slip and rotation of an object in a hand, for the ground truth.
//!
//! A hold begins when both fingertips of a hand press an object and its support carries less than
//! its weight. Motion while the fingers close therefore does not count. During the hold, the
//! object's pose in the hand is compared with that at the beginning. Phases in which the support
//! carries the object again do not count. The hold ends when a fingertip releases. The maxima over
//! all holds remain.

use nalgebra::{Matrix3, Vector3};

use crate::body::Body;

/// Share of the weight below which the support no longer carries an object. Design choice: closing
/// alone changes the load less.
const CARRIED_SHARE: f64 = 0.9;

/// Hand with both fingertips on an object, base frame.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Grip {
    pub(crate) hand: usize,
    pub(crate) base_from_hand: Matrix3<f64>,
    /// Middle between the fingertips, m.
    pub(crate) middle_m: Vector3<f64>,
    /// Unit vector between the fingertips.
    pub(crate) closing: Vector3<f64>,
}

impl Grip {
    /// Returns the grip of a hand that a bump displaces upwards.
    pub(crate) fn raised(mut self, by_m: f64) -> Self {
        self.middle_m.z += by_m;
        self
    }
}

/// Largest slip and rotation of an object over all holds.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Hold {
    reference: Option<Reference>,
    /// Slip tangential to the fingertips, m.
    pub(crate) slip_m: f64,
    pub(crate) turn_rad: f64,
}

/// Pose of the object in the hand at the beginning of a hold.
#[derive(Clone, Copy, Debug)]
struct Reference {
    hand: usize,
    hand_from_object: Matrix3<f64>,
    /// Middle between the fingertips, object frame, m.
    middle_m: Vector3<f64>,
}

impl Hold {
    /// Updates slip and rotation; `grip` is the hand with both fingertips on the object.
    pub(crate) fn update(&mut self, grip: Option<&Grip>, body: &Body) {
        let Some(grip) = grip else {
            self.reference = None;
            return;
        };
        let now = Reference::new(grip, body);
        let carried = body.table_n < CARRIED_SHARE * body.weight_n();
        match &self.reference {
            Some(before) if before.hand == grip.hand && !carried => {}
            Some(before) if before.hand == grip.hand => {
                let slid_m = body.base_from_body * (now.middle_m - before.middle_m);
                let along_m = slid_m - grip.closing * slid_m.dot(&grip.closing);
                self.slip_m = self.slip_m.max(along_m.norm());
                self.turn_rad = self.turn_rad.max(now.rotation_since_rad(before));
            }
            _ if carried => self.reference = Some(now),
            _ => self.reference = None,
        }
    }
}

impl Reference {
    fn new(grip: &Grip, body: &Body) -> Self {
        Self {
            hand: grip.hand,
            hand_from_object: grip.base_from_hand.tr_mul(&body.base_from_body),
            middle_m: body
                .base_from_body
                .tr_mul(&(grip.middle_m - body.position_m)),
        }
    }

    fn rotation_since_rad(&self, before: &Self) -> f64 {
        let turn = before.hand_from_object.tr_mul(&self.hand_from_object);
        libm::acos(((turn.trace() - 1.0) / 2.0).clamp(-1.0, 1.0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::body::{Motion, quaternion_about_z};
    use crate::shape::Shape;

    const GRIP: Grip = Grip {
        hand: 0,
        base_from_hand: Matrix3::new(1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0),
        middle_m: Vector3::new(0.3, 0.0, 0.05),
        closing: Vector3::new(0.0, 1.0, 0.0),
    };

    fn cube() -> Body {
        let shape = Shape::Box {
            half_m: Vector3::repeat(0.025),
        };
        Body::standing(shape, 0.1, [0.3, 0.0, 0.0], 0.0)
    }

    fn at(body: &mut Body, position_m: [f64; 3], yaw_rad: f64) {
        body.set_motion(&Motion {
            position_m: position_m.into(),
            orientation: quaternion_about_z(yaw_rad),
            velocity_m_s: Vector3::zeros(),
            angular_rad_s: Vector3::zeros(),
        });
    }

    #[test]
    fn only_an_unsupported_object_counts_as_held() {
        let (mut hold, mut body) = (Hold::default(), cube());
        hold.update(Some(&GRIP), &body);
        let weight_n = body.weight_n();
        at(&mut body, [0.303, 0.0, 0.025], 0.2);
        body.table_n = weight_n;
        hold.update(Some(&GRIP), &body);
        assert_eq!(
            (hold.slip_m, hold.turn_rad),
            (0.0, 0.0),
            "the object still stands"
        );
        body.table_n = 0.0;
        hold.update(Some(&GRIP), &body);
        at(&mut body, [0.303, 0.001, 0.023], 0.2);
        hold.update(Some(&GRIP), &body);
        assert!((hold.slip_m - 0.002).abs() < 1e-9, "{hold:?}");
        at(&mut body, [0.303, 0.001, 0.024], 0.3);
        hold.update(Some(&GRIP), &body);
        assert!((hold.turn_rad - 0.1).abs() < 1e-9, "{hold:?}");
        assert!(hold.slip_m >= 0.002, "the maximum remains");
        body.table_n = weight_n;
        at(&mut body, [0.303, 0.004, 0.024], 0.6);
        hold.update(Some(&GRIP), &body);
        assert!(hold.slip_m < 0.003, "standing does not count: {hold:?}");
        body.table_n = 0.0;
        at(&mut body, [0.303, 0.001, 0.024], 0.3);
        hold.update(None, &body);
        assert!(hold.slip_m >= 0.002, "the maximum remains after the hold");
        hold.update(Some(&GRIP), &body);
        let before = (hold.slip_m, hold.turn_rad);
        at(&mut body, [0.303, 0.001, 0.0235], 0.35);
        hold.update(Some(&GRIP), &body);
        assert_eq!(
            (hold.slip_m, hold.turn_rad),
            before,
            "maximum over all holds"
        );
    }
}
