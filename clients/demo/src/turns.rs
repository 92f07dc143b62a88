//! Counter of cap turns: a turn is one grip during which the cap rotates.

use robot_model::HandModel;
use shm_schemas::WorldTruth;

/// Normal force of a grasp side in contact, N (design choice: half of the controller's touch
/// threshold).
const CONTACT_N: f64 = 0.03;
/// Smallest rotation of a turn, rad (design choice: 5°, a tenth of a typical turn).
const TURN_RAD: f64 = 5.0 * core::f64::consts::PI / 180.0;

#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Turns {
    pub(crate) count: u32,
    grip: Option<Grip>,
}

#[derive(Clone, Copy, Debug)]
struct Grip {
    begun_rad: f64,
    counted: bool,
}

impl Turns {
    /// Updates with the first object, a cap, and the acting hand. A turn takes about 1 s, so slow
    /// polling suffices.
    pub(crate) fn update(&mut self, truth: &WorldTruth, hand: &HandModel) {
        let cap = &truth.objects[0];
        let normal_n = &truth.normal_n[hand.side().index()];
        let pressed = hand
            .grasp_sides()
            .both_exceed(CONTACT_N, |fingertip| normal_n[fingertip]);
        if !pressed || cap.cap_engaged == 0 {
            self.grip = None;
            return;
        }
        let grip = self.grip.get_or_insert(Grip {
            begun_rad: cap.cap_angle_rad,
            counted: false,
        });
        if !grip.counted && (cap.cap_angle_rad - grip.begun_rad).abs() >= TURN_RAD {
            grip.counted = true;
            self.count += 1;
        }
    }
}

#[cfg(test)]
mod tests {
    use robot_model::{HandSide, RobotModel};

    use super::*;

    /// Regression: the thumb was not considered, so that turns without its grip counted.
    #[test]
    fn turn_without_thumb_contact_does_not_count() {
        let robot = RobotModel::find("three-finger").expect("built-in robot");
        let check = |normal_n: [f64; 4], count| {
            let mut turns = Turns::default();
            for angle_deg in [0.0_f64, 48.0] {
                let mut truth = WorldTruth::default();
                truth.normal_n[1] = normal_n;
                truth.objects[0].cap_engaged = 1;
                truth.objects[0].cap_angle_rad = angle_deg.to_radians();
                turns.update(&truth, robot.hand(HandSide::Right));
            }
            assert_eq!(turns.count, count, "{normal_n:?}");
        };
        check([1.0, 1.0, 0.0, 0.0], 0);
        check([1.0, 0.0, 1.0, 0.0], 1);
    }

    #[test]
    fn only_grips_that_turn_the_cap_count() {
        let robot = RobotModel::two_hand_arm().expect("built-in robot");
        let hand = robot.hand(HandSide::Right);
        let check = |looks: &[(f64, bool, f64)], count| {
            let mut turns = Turns::default();
            for (normal_n, engaged, angle_deg) in looks {
                let mut truth = WorldTruth::default();
                truth.normal_n[1] = [*normal_n; 4];
                truth.objects[0].cap_engaged = (*engaged).into();
                truth.objects[0].cap_angle_rad = angle_deg.to_radians();
                turns.update(&truth, hand);
            }
            assert_eq!(turns.count, count, "{looks:?}");
        };
        check(&[(1.0, true, 0.0), (1.0, true, 3.0), (0.0, true, 3.0)], 0);
        check(&[(1.0, true, 0.0), (1.0, true, 20.0), (1.0, true, 48.0)], 1);
        check(
            &[
                (1.0, true, 0.0),
                (1.0, true, 48.0),
                (0.0, true, 48.0),
                (1.0, true, 48.0),
                (1.0, true, 90.0),
            ],
            2,
        );
        check(&[(1.0, false, 0.0), (1.0, false, 48.0)], 0);
        check(&[(f64::NAN, true, 0.0), (f64::NAN, true, 48.0)], 0);
        check(&[(1.0, true, 0.0), (1.0, true, -30.0)], 1);
    }
}
