//! Model of a servo shaft: position loop with a speed limit, current, temperature.

/// Gain of the position loop, 1/s. Design choice: an error decays to one third within 25 ms.
const LOOP_PER_S: f64 = 40.0;
/// Maximum acceleration, steps/s². Design choice: about 60 rad/s².
const ACCELERATION: f64 = 40_000.0;
/// Current per position error up to the limit, A per step. Design choice: 0.1 A at one degree.
const CURRENT_PER_STEP_A: f64 = 0.01;
/// Maximum integration step, s.
const STEP_S: f64 = 0.001;
/// Maximum simulated time per call, s.
const LONGEST_S: f64 = 1.0;
/// Room temperature, °C.
const ROOM_C: f64 = 25.0;
/// Heating, K/s per A², and time constant of cooling, s. Design choices.
const HEATING_K_S_A2: f64 = 1.0;
const COOLING_S: f64 = 60.0;

/// Set-points of the shaft.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct ShaftSetpoints {
    pub(super) torque_on: bool,
    pub(super) goal_steps: f64,
    /// Speed limit, steps/s.
    pub(super) speed_max: f64,
    /// Current limit, A.
    pub(super) current_max_a: f64,
}

/// State of the shaft.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Shaft {
    pub(super) position_steps: f64,
    pub(super) speed_steps_s: f64,
    pub(super) current_a: f64,
    pub(super) temperature_c: f64,
    /// Obstacle that blocks motion above this position.
    pub(super) wall_steps: Option<f64>,
    /// Maximum speed since the last reset, steps/s.
    pub(super) fastest_steps_s: f64,
}

impl Shaft {
    pub(super) fn new(position_steps: f64) -> Self {
        Self {
            position_steps,
            speed_steps_s: 0.0,
            current_a: 0.0,
            temperature_c: ROOM_C,
            wall_steps: None,
            fastest_steps_s: 0.0,
        }
    }

    /// Advances the shaft by a time, s.
    pub(super) fn advance(&mut self, orders: &ShaftSetpoints, elapsed_s: f64) {
        let mut left_s = elapsed_s.clamp(0.0, LONGEST_S);
        while left_s > 0.0 {
            let step_s = left_s.min(STEP_S);
            self.step(orders, step_s);
            left_s -= step_s;
        }
    }

    fn step(&mut self, orders: &ShaftSetpoints, step_s: f64) {
        let error = orders.goal_steps - self.position_steps;
        let wanted = if orders.torque_on {
            (LOOP_PER_S * error).clamp(-orders.speed_max, orders.speed_max)
        } else {
            0.0
        };
        let change = ACCELERATION * step_s;
        self.speed_steps_s += (wanted - self.speed_steps_s).clamp(-change, change);
        self.position_steps += self.speed_steps_s * step_s;
        if let Some(wall) = self.wall_steps.filter(|wall| self.position_steps > *wall) {
            (self.position_steps, self.speed_steps_s) = (wall, 0.0);
        }
        self.fastest_steps_s = self.fastest_steps_s.max(self.speed_steps_s.abs());
        // A register can hold a negative limit, which permits no current.
        let most_a = if orders.torque_on {
            orders.current_max_a.max(0.0)
        } else {
            0.0
        };
        self.current_a = (CURRENT_PER_STEP_A * error).clamp(-most_a, most_a);
        let heating_k_s = HEATING_K_S_A2 * self.current_a.powi(2);
        self.temperature_c += step_s * (heating_k_s + (ROOM_C - self.temperature_c) / COOLING_S);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ORDERS: ShaftSetpoints = ShaftSetpoints {
        torque_on: true,
        goal_steps: 1000.0,
        speed_max: 2000.0,
        current_max_a: 0.5,
    };

    #[test]
    fn shaft_reaches_goal_within_speed_limit() {
        let mut shaft = Shaft::new(0.0);
        shaft.advance(&ORDERS, 0.25);
        assert!(shaft.position_steps < 510.0, "{shaft:?}");
        shaft.advance(&ORDERS, 1.0);
        assert!((shaft.position_steps - 1000.0).abs() < 1.0, "{shaft:?}");
        assert!(shaft.fastest_steps_s <= 2000.0);
    }

    #[test]
    fn blocked_shaft_draws_current_limit_and_heats() {
        let mut shaft = Shaft {
            wall_steps: Some(500.0),
            ..Shaft::new(0.0)
        };
        (0..20).for_each(|_| shaft.advance(&ORDERS, 1.0));
        assert_eq!((shaft.position_steps, shaft.current_a), (500.0, 0.5));
        assert!(shaft.temperature_c > 28.0, "{shaft:?}");
    }

    /// Regression: a negative current limit panicked.
    #[test]
    fn negative_current_limit_permits_no_current() {
        let mut shaft = Shaft::new(0.0);
        let orders = ShaftSetpoints {
            current_max_a: -0.1,
            ..ORDERS
        };
        shaft.advance(&orders, 0.1);
        assert_eq!(shaft.current_a, 0.0);
    }

    #[test]
    fn shaft_without_torque_does_not_move() {
        let mut shaft = Shaft::new(10.0);
        let orders = ShaftSetpoints {
            torque_on: false,
            ..ORDERS
        };
        shaft.advance(&orders, 1.0);
        assert_eq!((shaft.position_steps, shaft.current_a), (10.0, 0.0));
    }
}
