//! How a servo's shaft moves, and what that costs: a position loop within a speed limit, a current, a temperature.

/// Stiffness of the position loop: speed per error, 1/s. Ours: an error is gone to a third within 25 ms.
const LOOP_PER_S: f64 = 40.0;
/// Fastest change of speed, steps/s² (ours: 60 rad/s²).
const ACCELERATION: f64 = 40_000.0;
/// Current per error of position, A per step, up to the limit. Ours: 0.1 A at one degree.
const CURRENT_PER_STEP_A: f64 = 0.01;
/// Longest step of the integration, s.
const STEP_S: f64 = 0.001;
/// Longest time that is made up for, s.
const LONGEST_S: f64 = 1.0;
/// Temperature of the room, °C.
const ROOM_C: f64 = 25.0;
/// Heating, K/s per A², and time constant of cooling, s. Ours.
const HEATING_K_S_A2: f64 = 1.0;
const COOLING_S: f64 = 60.0;

/// What a servo is told.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Orders {
    pub(super) torque_on: bool,
    pub(super) goal_steps: f64,
    /// Speed limit, steps/s.
    pub(super) speed_max: f64,
    /// Current limit, A.
    pub(super) current_max_a: f64,
}

/// A shaft.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Shaft {
    pub(super) position_steps: f64,
    pub(super) speed_steps_s: f64,
    pub(super) current_a: f64,
    pub(super) temperature_c: f64,
    /// Something in the way, which it cannot pass upwards.
    pub(super) wall_steps: Option<f64>,
    /// Farthest that it moved between two looks since it was last asked, steps.
    pub(super) fastest_steps_s: f64,
}

impl Shaft {
    pub(super) fn at(position_steps: f64) -> Self {
        Self {
            position_steps,
            speed_steps_s: 0.0,
            current_a: 0.0,
            temperature_c: ROOM_C,
            wall_steps: None,
            fastest_steps_s: 0.0,
        }
    }

    /// Lets time pass.
    pub(super) fn advance(&mut self, orders: &Orders, elapsed_s: f64) {
        let mut left_s = elapsed_s.clamp(0.0, LONGEST_S);
        while left_s > 0.0 {
            let step_s = left_s.min(STEP_S);
            self.step(orders, step_s);
            left_s -= step_s;
        }
    }

    fn step(&mut self, orders: &Orders, step_s: f64) {
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
        let most_a = if orders.torque_on {
            orders.current_max_a
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

    const ORDERS: Orders = Orders {
        torque_on: true,
        goal_steps: 1000.0,
        speed_max: 2000.0,
        current_max_a: 0.5,
    };

    #[test]
    fn it_goes_there_no_faster_than_it_may() {
        let mut shaft = Shaft::at(0.0);
        shaft.advance(&ORDERS, 0.25);
        assert!(shaft.position_steps < 510.0, "{shaft:?}");
        shaft.advance(&ORDERS, 1.0);
        assert!((shaft.position_steps - 1000.0).abs() < 1.0, "{shaft:?}");
        assert!(shaft.fastest_steps_s <= 2000.0);
    }

    #[test]
    fn it_presses_against_a_wall_with_its_limit_and_gets_warm() {
        let mut shaft = Shaft {
            wall_steps: Some(500.0),
            ..Shaft::at(0.0)
        };
        (0..20).for_each(|_| shaft.advance(&ORDERS, 1.0));
        assert_eq!((shaft.position_steps, shaft.current_a), (500.0, 0.5));
        assert!(shaft.temperature_c > 28.0, "{shaft:?}");
    }

    #[test]
    fn without_torque_it_stays() {
        let mut shaft = Shaft::at(10.0);
        let orders = Orders {
            torque_on: false,
            ..ORDERS
        };
        shaft.advance(&orders, 1.0);
        assert_eq!((shaft.position_steps, shaft.current_a), (10.0, 0.0));
    }
}
