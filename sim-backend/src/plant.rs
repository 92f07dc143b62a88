//! The robot's joints as their servos drive them.
//!
//! Each joint is a second-order system of its own: torque = K·(commanded − actual) + D·(fed forward − actual velocity),
//! cut to the drive's limit, against the joint's reflected inertia. Gravity is compensated; contact forces arrive as
//! joint torques. Full rigid-body dynamics with the same servos give the same contact slopes (robot design), so the
//! joints stay decoupled.

use robot_model::{HAND_JOINTS, HandModel, HandVector};

/// Reflected inertia, kg·m², and natural frequency, rad/s, of each joint of a hand (robot design, servo table):
/// shoulder yaw, shoulder pitch, elbow pitch, wrist pitch, wrist roll, then root, knuckle, distal of each finger.
const SERVOS: [(f64, f64); HAND_JOINTS] = [
    (0.45, 120.0),
    (0.45, 120.0),
    (0.2, 120.0),
    (0.05, 160.0),
    (0.02, 160.0),
    (2e-3, 200.0),
    (1e-3, 200.0),
    (1e-3, 200.0),
    (2e-3, 200.0),
    (1e-3, 200.0),
    (1e-3, 200.0),
];
/// Damping ratio of every servo (robot design).
const DAMPING_RATIO: f64 = 1.0;

/// Stiffness of every joint servo of a hand, N·m/rad: what a controller needs to feed the fingers' compliance forward.
#[must_use]
pub fn servo_stiffness_n_m_rad() -> HandVector {
    HandVector::from_fn(|joint, _| stiffness(joint))
}

fn stiffness(joint: usize) -> f64 {
    let (inertia, omega) = SERVOS[joint];
    inertia * omega * omega
}

fn damping(joint: usize) -> f64 {
    let (inertia, omega) = SERVOS[joint];
    2.0 * DAMPING_RATIO * inertia * omega
}

/// The eleven joints of one hand.
#[derive(Clone, Debug)]
pub(crate) struct Plant {
    lower_rad: HandVector,
    upper_rad: HandVector,
    effort_max_n_m: HandVector,
    stiffness_n_m_rad: HandVector,
    pub(crate) position_rad: HandVector,
    pub(crate) velocity_rad_s: HandVector,
    /// Torque of the servos in the last step, N·m.
    pub(crate) effort_n_m: HandVector,
}

impl Plant {
    /// Joints at rest, whose servos are stiffer than the table says by these factors; their damping is the table's.
    pub(crate) fn at(
        model: &HandModel,
        position_rad: HandVector,
        stiffness_factor: &HandVector,
    ) -> Self {
        let of = |value: fn(&robot_model::Joint) -> f64| {
            HandVector::from_fn(|i, _| value(&model.joints()[i]))
        };
        Self {
            lower_rad: of(|joint| joint.lower_rad),
            upper_rad: of(|joint| joint.upper_rad),
            effort_max_n_m: of(|joint| joint.effort_max_n_m),
            stiffness_n_m_rad: servo_stiffness_n_m_rad().component_mul(stiffness_factor),
            position_rad,
            velocity_rad_s: HandVector::zeros(),
            effort_n_m: HandVector::zeros(),
        }
    }

    /// One step of `dt_s` towards where the reference is at its beginning, under the torques of contact.
    pub(crate) fn step(
        &mut self,
        reference_rad: &HandVector,
        feed_forward_rad_s: &HandVector,
        contact_n_m: &HandVector,
        dt_s: f64,
    ) {
        for joint in 0..HAND_JOINTS {
            let error_rad = reference_rad[joint] - self.position_rad[joint];
            let error_rad_s = feed_forward_rad_s[joint] - self.velocity_rad_s[joint];
            let stiffness_n_m_rad = self.stiffness_n_m_rad[joint];
            let wanted_n_m = stiffness_n_m_rad * error_rad + damping(joint) * error_rad_s;
            let limit_n_m = self.effort_max_n_m[joint];
            let effort_n_m = wanted_n_m.clamp(-limit_n_m, limit_n_m);
            self.effort_n_m[joint] = effort_n_m;
            let (inertia_kg_m2, _) = SERVOS[joint];
            self.velocity_rad_s[joint] +=
                (effort_n_m + contact_n_m[joint]) * (dt_s / inertia_kg_m2);
            self.move_joint(joint, dt_s);
        }
    }

    /// Moves a joint at its velocity; a mechanical stop takes the velocity away.
    fn move_joint(&mut self, joint: usize, dt_s: f64) {
        let wanted_rad = self.position_rad[joint] + self.velocity_rad_s[joint] * dt_s;
        let stopped_rad = wanted_rad.clamp(self.lower_rad[joint], self.upper_rad[joint]);
        if stopped_rad != wanted_rad {
            self.velocity_rad_s[joint] = 0.0;
        }
        self.position_rad[joint] = stopped_rad;
    }

    /// Whether every number is finite.
    pub(crate) fn is_finite(&self) -> bool {
        (self.position_rad.sum() + self.velocity_rad_s.sum()).is_finite()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use robot_model::{RobotModel, Side};

    const DT_S: f64 = 250e-6;

    fn plant() -> Plant {
        let robot = RobotModel::two_hand_arm().expect("the built-in robot loads");
        let hand = robot.hand(Side::Right);
        Plant::at(hand, *hand.reference_rad(), &HandVector::repeat(1.0))
    }

    #[test]
    fn servo_table_of_the_robot_design() {
        let k = servo_stiffness_n_m_rad();
        let expected = [
            6480.0, 6480.0, 2880.0, 1280.0, 512.0, 80.0, 40.0, 40.0, 80.0, 40.0, 40.0,
        ];
        assert!(
            k.iter().zip(expected).all(|(k, e)| (k - e).abs() < 1e-9),
            "{k}"
        );
        let d: Vec<f64> = (0..HAND_JOINTS).map(damping).collect();
        let expected = [108.0, 108.0, 48.0, 16.0, 6.4, 0.8, 0.4, 0.4, 0.8, 0.4, 0.4];
        assert!(
            d.iter().zip(expected).all(|(d, e)| (d - e).abs() < 1e-9),
            "{d:?}"
        );
    }

    /// Without the velocity feed-forward the lag would be 2/ω_n: 10 ms at the fingers.
    #[test]
    fn a_ramp_is_tracked_without_lag() {
        let mut plant = plant();
        let (mut reference, speed) = (plant.position_rad, HandVector::repeat(0.1));
        for _ in 0..4000 {
            plant.step(&reference, &speed, &HandVector::zeros(), DT_S);
            reference += speed * DT_S;
        }
        let lag_rad = (reference - plant.position_rad).amax();
        assert!(lag_rad < 1e-6, "lag {lag_rad} rad");
    }

    #[test]
    fn a_load_moves_a_joint_by_its_compliance() {
        let mut plant = plant();
        let (reference, load) = (plant.position_rad, HandVector::repeat(0.1));
        (0..8000).for_each(|_| plant.step(&reference, &HandVector::zeros(), &load, DT_S));
        let sag = (plant.position_rad - reference).component_mul(&servo_stiffness_n_m_rad());
        assert!(
            sag.iter().all(|torque| (torque - 0.1).abs() < 1e-6),
            "{sag}"
        );
    }

    #[test]
    fn absurd_references_end_at_the_stops_with_bounded_torque() {
        let mut plant = plant();
        let (reference, speed) = (HandVector::repeat(1e300), HandVector::repeat(-1e300));
        for _ in 0..8000 {
            plant.step(&reference, &speed, &HandVector::zeros(), DT_S);
        }
        assert!(plant.is_finite());
        assert!(
            plant
                .effort_n_m
                .iter()
                .zip(&plant.effort_max_n_m)
                .all(|(e, max)| e.abs() <= *max)
        );
        let inside =
            |j: usize| (plant.lower_rad[j]..=plant.upper_rad[j]).contains(&plant.position_rad[j]);
        assert!((0..HAND_JOINTS).all(inside));
    }
}
