//! What the controller is wired to: which sensors exist, and how they are laid out.

use robot_model::{RobotModel, Side};
use shm_schemas::Layout;
use shm_schemas::capacity::HANDS;

/// One hand's sensor.
#[derive(Clone, Copy, Debug)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct HandWiring {
    /// Where the elements sit; frames with another layout are refused.
    pub layout: Layout,
    /// Fingers that carry sensors, 1 to 4; frames with fewer are refused.
    pub fingers: usize,
    /// Whether the robot must hold when this hand's sensor is silent. A hand without a sensor takes no goals.
    pub required: bool,
    /// Nominal frame rate, Hz: the longest silence that is normal is a few periods.
    pub rate_hz: f64,
}

/// Everything that does not change while the controller lives.
#[derive(Clone, Copy, Debug)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Wiring {
    /// Per hand, left first.
    pub hands: [HandWiring; HANDS],
    /// Whether joint feedback exists. Without it the controller only senses and never leaves INIT.
    pub joints_required: bool,
    /// Nominal tick period, s.
    pub tick_s: f64,
    /// Epoch that the commands carry; drawn anew at each start, fixed in lock-step.
    pub writer_epoch: u64,
}

impl Default for HandWiring {
    fn default() -> Self {
        Self {
            layout: Layout::dome_41(),
            fingers: 2,
            required: true,
            rate_hz: 1000.0,
        }
    }
}

impl Wiring {
    /// A robot whose every hand feels with all its fingertips, at 1 kHz.
    #[must_use]
    pub fn of(robot: &RobotModel) -> Self {
        let hand = |side: Side| HandWiring {
            layout: robot.hand(side).skin().layout.layout(),
            fingers: robot.hand(side).finger_count().max(1),
            required: robot.hand(side).is_present(),
            ..HandWiring::default()
        };
        Self {
            hands: Side::BOTH.map(hand),
            ..Self::default()
        }
    }
}

impl Default for Wiring {
    fn default() -> Self {
        Self {
            hands: [HandWiring::default(), HandWiring::default()],
            joints_required: true,
            tick_s: 0.001,
            writer_epoch: 1,
        }
    }
}
