//! Joint servo dynamics of one hand.
//!
//! Each joint is an independent second-order system: torque = K·(commanded − actual) + D·(commanded
//! velocity − actual velocity), limited to the drive's maximum, acting on the joint's reflected
//! inertia. Stiffness and inertia come from the robot file. Gravity is compensated; contact forces
//! enter as joint torques.
//!
//! The joints stay decoupled: full rigid-body dynamics with the same servos give the same contact
//! slopes (robot design).

use robot_model::{HandModel, HandVector};

/// Damping ratio of every servo (robot design).
const DAMPING_RATIO: f64 = 1.0;

#[derive(Clone, Debug)]
pub(crate) struct Plant {
    lower: HandVector,
    upper: HandVector,
    effort_max: HandVector,
    stiffness: HandVector,
    damping: HandVector,
    inertia_kg_m2: HandVector,
    pub(crate) position: HandVector,
    pub(crate) velocity: HandVector,
    /// Servo torque in the last step, N·m.
    pub(crate) effort: HandVector,
}

impl Plant {
    /// Returns joints at rest. Servo stiffness is the model's times `stiffness_factor`; damping is
    /// the model's.
    pub(crate) fn at_rest(
        model: &HandModel,
        position: HandVector,
        stiffness_factor: &HandVector,
    ) -> Self {
        let of = |value: fn(&robot_model::Joint) -> f64| {
            HandVector::from_fn(model.joints().len(), |i| value(&model.joints()[i]))
        };
        let rest = of(|_| 0.0);
        Self {
            lower: of(|joint| joint.lower),
            upper: of(|joint| joint.upper),
            effort_max: of(|joint| joint.effort_max),
            stiffness: model
                .stiffness()
                .zip_map(stiffness_factor, |stiffness, factor| stiffness * factor),
            damping: of(|joint| {
                let critical = libm::sqrt(joint.stiffness * joint.inertia_kg_m2);
                2.0 * DAMPING_RATIO * critical
            }),
            inertia_kg_m2: of(|joint| joint.inertia_kg_m2),
            position,
            velocity: rest,
            effort: rest,
        }
    }

    /// Integrates one step of `dt_s` towards the reference at its beginning, under contact torques.
    pub(crate) fn step(
        &mut self,
        reference: &HandVector,
        feed_forward_rad_s: &HandVector,
        contact_n_m: &HandVector,
        dt_s: f64,
    ) {
        let count = self.position.len();
        let (position, velocity) = (&mut self.position[..count], &mut self.velocity[..count]);
        let effort = &mut self.effort[..count];
        let (reference, feed_forward_rad_s, contact_n_m) = (
            &reference[..count],
            &feed_forward_rad_s[..count],
            &contact_n_m[..count],
        );
        let (stiffness, damping) = (&self.stiffness[..count], &self.damping[..count]);
        let (inertia, limit) = (&self.inertia_kg_m2[..count], &self.effort_max[..count]);
        let (lower, upper) = (&self.lower[..count], &self.upper[..count]);
        for i in 0..count {
            let error_rad = reference[i] - position[i];
            let error_rad_s = feed_forward_rad_s[i] - velocity[i];
            let wanted_n_m = stiffness[i] * error_rad + damping[i] * error_rad_s;
            effort[i] = wanted_n_m.clamp(-limit[i], limit[i]);
            let pushed_n_m = effort[i] + contact_n_m[i];
            let speed = velocity[i] + pushed_n_m * (dt_s / inertia[i]);
            let request = position[i] + speed * dt_s;
            position[i] = request.clamp(lower[i], upper[i]);
            // A mechanical stop sets the velocity to zero.
            let is_stopped = position[i] != request;
            velocity[i] = if is_stopped { 0.0 } else { speed };
        }
    }

    /// Returns whether all positions and velocities are finite.
    pub(crate) fn is_finite(&self) -> bool {
        let mut numbers = self.position.iter().chain(self.velocity.iter());
        numbers.all(|value| value.is_finite())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use robot_model::{HandSide, RobotModel};

    const DT_S: f64 = 250e-6;

    fn plant() -> Plant {
        let robot = RobotModel::two_hand_arm().expect("the built-in robot loads");
        let hand = robot.hand(HandSide::Right);
        Plant::at_rest(hand, *hand.reference(), &HandVector::repeat(11, 1.0))
    }

    #[test]
    fn servos_are_critically_damped() {
        let d = plant().damping;
        let expected = [108.0, 108.0, 48.0, 16.0, 6.4, 0.8, 0.4, 0.4, 0.8, 0.4, 0.4];
        assert!(
            d.iter().zip(expected).all(|(d, e)| (d - e).abs() < 1e-9),
            "{d:?}"
        );
    }

    /// Without velocity feed-forward the lag would be 2/ω_n: 10 ms at the finger joints.
    #[test]
    fn a_ramp_is_tracked_without_lag() {
        let mut plant = plant();
        let (mut reference, speed) = (plant.position, HandVector::repeat(11, 0.1));
        for _ in 0..4000 {
            plant.step(&reference, &speed, &HandVector::zeros(11), DT_S);
            reference += speed * DT_S;
        }
        let lag_rad = (reference - plant.position).amax();
        assert!(lag_rad < 1e-6, "lag {lag_rad} rad");
    }

    #[test]
    fn load_deflects_a_joint_by_its_compliance() {
        let mut plant = plant();
        let (reference, load) = (plant.position, HandVector::repeat(11, 0.1));
        (0..8000).for_each(|_| plant.step(&reference, &HandVector::zeros(11), &load, DT_S));
        let sag = (plant.position - reference).zip_map(&plant.stiffness, |off, k| off * k);
        assert!(
            sag.iter().all(|torque| (torque - 0.1).abs() < 1e-6),
            "{sag:?}"
        );
    }

    #[test]
    fn extreme_references_end_at_the_stops() {
        let mut plant = plant();
        let (reference, speed) = (
            HandVector::repeat(11, 1e300),
            HandVector::repeat(11, -1e300),
        );
        for _ in 0..8000 {
            plant.step(&reference, &speed, &HandVector::zeros(11), DT_S);
        }
        assert!(plant.is_finite());
        assert!(
            plant
                .effort
                .iter()
                .zip(plant.effort_max.iter())
                .all(|(e, max)| e.abs() <= *max)
        );
        let inside = |j: usize| (plant.lower[j]..=plant.upper[j]).contains(&plant.position[j]);
        assert!((0..11).all(inside));
    }
}
