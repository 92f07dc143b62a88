//! Sensor set-up of the controller.

use robot_model::{HandSide, RobotModel};
use shm_schemas::Layout;
use shm_schemas::capacity::HANDS;

/// Tactile sensor of one hand.
#[derive(Clone, Copy, Debug)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct HandSensorSetup {
    /// Element layout; frames with another one are rejected.
    pub layout: Layout,
    /// Fingertips with sensors, 1 to 4; frames with fewer are rejected.
    pub fingers: usize,
    /// Requires HOLD while this sensor is silent. A hand without a sensor accepts no goals.
    pub required: bool,
    /// Nominal frame rate, Hz; gaps of a few periods are tolerated.
    pub rate_hz: f64,
}

/// Constant set-up of a controller.
#[derive(Clone, Copy, Debug)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct SensorSetup {
    /// Sensor per hand, left first.
    pub hands: [HandSensorSetup; HANDS],
    /// Requires joint feedback; without it the controller stays in INIT and only senses.
    pub joints_required: bool,
    /// Nominal tick period, s.
    pub tick_s: f64,
    /// Epoch of the commands: random at each start, fixed in lock-step.
    pub writer_epoch: u64,
}

impl Default for HandSensorSetup {
    fn default() -> Self {
        Self {
            layout: Layout::dome_41(),
            fingers: 2,
            required: true,
            rate_hz: 1000.0,
        }
    }
}

impl SensorSetup {
    /// Creates a set-up with 1 kHz tactile sensors on all fingertips.
    ///
    /// ```
    /// use atas_core::SensorSetup;
    /// use robot_model::RobotModel;
    ///
    /// let robot = RobotModel::find("three-finger")?;
    /// let set_up = SensorSetup::from_robot(&robot);
    /// assert!(set_up.hands.iter().any(|hand| hand.fingers == 3));
    /// # Ok::<(), robot_model::ModelError>(())
    /// ```
    #[must_use]
    pub fn from_robot(robot: &RobotModel) -> Self {
        let hand = |side: HandSide| HandSensorSetup {
            layout: robot.hand(side).skin().layout.layout(),
            fingers: robot.hand(side).fingertip_count().max(1),
            required: robot.hand(side).is_present(),
            ..HandSensorSetup::default()
        };
        Self {
            hands: HandSide::BOTH.map(hand),
            ..Self::default()
        }
    }
}

impl Default for SensorSetup {
    fn default() -> Self {
        Self {
            hands: [HandSensorSetup::default(), HandSensorSetup::default()],
            joints_required: true,
            tick_s: 0.001,
            writer_epoch: 1,
        }
    }
}
