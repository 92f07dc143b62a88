//! Lag of the servos: a first-order low-pass between commanded and executed set-points.
//!
//! Positions and velocities pass the same filter, so the velocity remains the derivative of the
//! position. Joint states report the commanded positions, as a servo reports its goal register.

use robot_model::RobotVector;
use shm_schemas::JointSetpoints;

use crate::clock::TICK_S;

#[derive(Clone, Debug)]
pub(crate) struct ServoLag {
    /// Share of the remaining distance per tick.
    share: f64,
    executed: JointSetpoints,
}

impl ServoLag {
    /// Returns servos at rest at these positions; `None` without lag.
    pub(crate) fn new(lag_s: f64, position: &RobotVector) -> Option<Self> {
        (lag_s > 0.0).then(|| Self {
            share: 1.0 - libm::exp(-TICK_S / lag_s),
            executed: JointSetpoints::holding(position),
        })
    }

    /// Advances one tick towards the commanded set-points; returns the executed ones.
    pub(crate) fn follow(&mut self, commanded: &JointSetpoints) -> JointSetpoints {
        let executed = &mut self.executed;
        let positions = executed.position.iter_mut();
        for (executed, commanded) in positions.zip(&commanded.position) {
            *executed += self.share * (commanded - *executed);
        }
        let velocities = executed.velocity.iter_mut();
        for (executed, commanded) in velocities.zip(&commanded.velocity) {
            *executed += self.share * (commanded - *executed);
        }
        *executed
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn step_is_followed_with_the_time_constant() {
        let mut lag = ServoLag::new(0.02, &RobotVector::zeros(3)).expect("a lag");
        let mut commanded = JointSetpoints::holding(&RobotVector::repeat(3, 1.0));
        let after = |lag: &mut ServoLag, ticks: usize, commanded: &JointSetpoints| {
            let executed = (0..ticks).map(|_| lag.follow(commanded).position[1]);
            executed.last().expect("some")
        };
        let reached = after(&mut lag, 20, &commanded);
        assert!((reached - 0.632).abs() < 1e-3, "{reached}");
        assert!(after(&mut lag, 200, &commanded) > 0.9999);
        // A ramp is followed in parallel, 20 ms late.
        commanded.velocity.fill(0.5);
        for _ in 0..500 {
            commanded.position.iter_mut().for_each(|p| *p += 0.5e-3);
            lag.follow(&commanded);
        }
        let executed = lag.follow(&commanded);
        let behind = commanded.position[1] - executed.position[1];
        assert!((behind - 0.5 * 0.0195).abs() < 5e-4, "{behind}");
        assert!((executed.velocity[1] - 0.5).abs() < 1e-6);
        assert!(ServoLag::new(0.0, &RobotVector::zeros(3)).is_none());
    }
}
