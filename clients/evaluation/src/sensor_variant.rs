//! Sensor variant of a trial: changed tactile frames and settings.

use atas_core::Settings;
use shm_schemas::HandFrame;

/// Settings and frame filter that replace those of the plan.
pub struct SensorVariant {
    /// Controller settings.
    pub settings: Settings,
    /// Modifies each tactile frame between fingertips and controller; must re-seal the frame.
    pub frame_filter: Box<dyn FnMut(&mut HandFrame)>,
}

impl SensorVariant {
    pub(crate) fn unmodified(settings: Settings) -> Self {
        Self {
            settings,
            frame_filter: Box::new(|_| {}),
        }
    }
}
